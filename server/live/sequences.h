// POST /v1/sequences: many frames in one answer, sent as they are drawn.
//
// A client of POST /v1/frames within the server: each frame is the one that a single request for it
// gives, takes its turn among those of others, and is asked for again while the queue is full.
#pragma once

#include "server/base/call.h"

namespace clerestory {

class Server;

Answer postSequence(Server& server, const Call& call);

}  // namespace clerestory
