// What long work answers: GET and DELETE of /v1/jobs/{id}, and the pictures it made.
#pragma once

#include "server/base/call.h"
#include "server/jobs/jobs.h"

namespace clerestory {

class Service;

Answer getJob(Service& service, const Call& call);
Answer cancelJob(Service& service, const Call& call);
Answer getJobPicture(Service& service, const Call& call);

// What a client is told of a job.
Answer toldJob(const JobStatus& status);
// The same as 202, with the job's place in Location.
Answer accepted(const JobStatus& status);

// "/v1/jobs/ID...", as in a path or in Location -> "ID"; empty for any other.
std::string jobIdIn(std::string_view path);

}  // namespace clerestory
