// GET /v1/stream: a view as motion JPEG, for <img> and for robotics tools; and the views that
// somebody moves for others to watch.
#pragma once

#include "server/base/call.h"

namespace clerestory {

class Server;

Answer putView(Server& server, const Call& call);
Answer getView(Server& server, const Call& call);
Answer getStream(Server& server, const Call& call);

}  // namespace clerestory
