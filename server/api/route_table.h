// Path and method -> handler; and the conversion of exceptions into problem documents.
#pragma once

#include "server/base/call.h"
#include "server/base/problem.h"

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace clerestory {

// The routes of one or several groups. Each group is a struct of references to the components that
// its handlers use.
class Routes {
public:
    // "{id}" in the path matches any part that is not empty. `components` is copied.
    template <class Components>
    void add(const char* path, const char* method, const Components& components,
             Answer (*handler)(const Components&, const Call&)) {
        rows_.push_back({path, method, [components, handler](const Call& call) {
                             return handler(components, call);
                         }});
    }

    // Empty if there is no such path. Sets `route` to the path of the row. Throws RequestError 405,
    // and what the handler throws.
    std::optional<Answer> answer(const Call& call, std::string& route) const;

    // Path and method of every route.
    std::vector<std::pair<std::string, std::string>> paths() const;

private:
    struct Row {
        const char* path;
        const char* method;
        std::function<Answer(const Call&)> handler;
    };
    std::vector<Row> rows_;
};

// Whether the pattern matches the path.
bool covers(std::string_view pattern, std::string_view path);

// The answer for a method that the path does not have: to OPTIONS the methods that it has; throws
// RequestError 405 for any other. `allow` lists the methods.
Answer otherMethod(const Call& call, const std::string& allow);

// The problem for the exception that is being handled; logs unexpected ones. Call in a catch block.
Problem currentProblem(const std::string& requestId);

// The answer, or the problem that `handle` threw. Does not throw.
Answer guarded(const Call& call, const std::function<Answer()>& handle);
Answer problemAnswer(const Problem& problem, const std::string& requestId);

}  // namespace clerestory
