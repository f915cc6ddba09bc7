#include "scene/import/import.h"
