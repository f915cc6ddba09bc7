// Path and method -> handler, for whoever has routes; and the one try at the edge of every handler.
#pragma once

#include "server/base/call.h"
#include "server/base/problem.h"

#include <optional>
#include <span>

namespace clerestory {

template <class Owner>
struct Route {
    const char* path;  // "{id}" stands for any part
    const char* method;
    Answer (*answer)(Owner&, const Call&);
};

// "{id}" in the pattern covers any part that is not empty.
bool covers(std::string_view pattern, std::string_view path);

// For a path that is there: OPTIONS, or RequestError 405. `allow` lists its methods.
Answer otherMethod(const Call& call, const std::string& allow);

// What the table has for the call; nothing when it has no such path. Throws RequestError 405 and
// what handlers throw. `route` becomes the row's path.
template <class Owner>
std::optional<Answer> routed(std::span<const Route<Owner>> table, Owner& owner, const Call& call,
                             std::string& route) {
    std::string allow;
    for (const Route<Owner>& row : table) {
        if (!covers(row.path, call.path)) continue;
        route = row.path;
        if (call.method == row.method) return row.answer(owner, call);
        allow += (allow.empty() ? "" : ", ") + std::string(row.method);
        if (row.method == std::string_view("GET")) allow += ", HEAD";
    }
    if (allow.empty()) return std::nullopt;
    return otherMethod(call, allow);
}

// The answer, or the problem that `handle` threw. Never throws.
Answer guarded(const Call& call, const std::function<Answer()>& handle);
Answer problemAnswer(const Problem& problem, const std::string& requestId);

}  // namespace clerestory
