// GET /v1/stream: a view as motion JPEG, for <img> and for robotics tools; and the views that
// somebody moves for others to watch.
#pragma once

#include "server/call.h"

namespace clerestory {

class Service;

Answer putView(Service& service, const Call& call);
Answer getView(Service& service, const Call& call);
Answer getStream(Service& service, const Call& call);

}  // namespace clerestory
