// POST /v1/comparisons: what accuracies cost and how far each is from the truth, as a job.
#pragma once

#include "server/base/call.h"

namespace clerestory {

class Service;

Answer postComparison(Service& service, const Call& call);

}  // namespace clerestory
