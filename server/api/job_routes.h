// The routes of jobs: POST /v1/comparisons starts one; GET and DELETE of /v1/jobs/{id}; the
// pictures of a result.
#pragma once

#include "server/api/frame_service.h"
#include "server/api/route_table.h"
#include "server/base/call.h"
#include "server/jobs/comparisons.h"
#include "server/jobs/jobs.h"

namespace clerestory {

struct JobRoutes {
    FrameService& frames;
    Jobs& jobs;
    Comparisons& comparisons;
};
void addRoutes(Routes& routes, const JobRoutes& components);

// 200 with the job as JSON.
Answer jobAnswer(const JobStatus& status);
// 202 with the job as JSON and its path in Location.
Answer jobStarted(const JobStatus& status);
// 404.
Answer jobUnknown(const std::string& id, const std::string& requestId);

}  // namespace clerestory
