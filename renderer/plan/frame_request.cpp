#include "plan/frame_request.h"
