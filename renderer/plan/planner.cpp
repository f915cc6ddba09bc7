#include "plan/planner.h"
