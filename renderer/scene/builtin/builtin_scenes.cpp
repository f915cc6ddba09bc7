#include "scene/builtin/builtin_scenes.h"
