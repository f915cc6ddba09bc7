// PlanHash: the hash of what a pass draws.
#pragma once

#include "scene/hash.h"
