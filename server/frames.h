// Frames and plans over HTTP.
#pragma once

#include "server/call.h"

namespace clerestory {

class Service;

Answer postFrame(Service& service, const Call& call);
Answer getFrame(Service& service, const Call& call);
Answer postPlan(Service& service, const Call& call);

}  // namespace clerestory
