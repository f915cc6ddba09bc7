#include "scene/bounds.h"
