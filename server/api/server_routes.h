// URL -> handler, for everything: what the server answers itself, and what it asks of whoever
// draws. Logs and counts every answer.
#pragma once

#include "server/base/call.h"
#include "server/base/problem.h"

#include <optional>

namespace clerestory {

class Server;

// Never throws.
Answer answerTo(Server& server, const Call& call);
// For the thread that serves every connection: waits for nobody. Nothing for what takes longer.
std::optional<Answer> quickAnswerTo(Server& server, const Call& call);
Answer answerWith(Server& server, const Call& call, const Problem& problem);

// What a token does not guard, and what a signed link opens; the path as it came.
bool isOpenPath(std::string_view path);
bool isLinkedPath(std::string_view path);

// Path (with "{id}" for its last part) and method of every route; for /openapi.json and its test.
std::vector<std::pair<std::string, std::string>> routePaths();

}  // namespace clerestory
