#include "scene/mesh_builder.h"
