// URL -> handler, for what is answered where the renderer is.
#pragma once

#include "server/base/call.h"

namespace clerestory {

class Service;

// Never throws.
Answer answerTo(Service& service, const Call& call);

// Path (with "{id}" for its last part) and method of every route.
std::vector<std::pair<std::string, std::string>> serviceRoutePaths();

}  // namespace clerestory
