#include "plan/frame_plan.h"
