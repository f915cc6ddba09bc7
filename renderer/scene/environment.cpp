#include "scene/environment.h"
