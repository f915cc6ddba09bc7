// POST /v1/scenes and DELETE /v1/scenes/{id}: scenes of clients. They are kept here, on the port's
// side, so that every renderer that comes finds them.
#pragma once

#include "server/base/call.h"

namespace clerestory {

class Server;

// The body is the file: .glb, .gltf, .zip, .tar or .tar.gz; the query may hold its `title`. 201
// where it has become a scene, 200 where it had been one before, 202 while it loads. Throws
// RequestError: uploads are off (403), of no known kind (415), no scene in it (422), no room (507).
Answer postScene(Server& server, const Call& call);
Answer deleteScene(Server& server, const Call& call);

}  // namespace clerestory
