#include "server/live/inner_call.h"

#include "server/api/server_routes.h"
#include "server/server.h"

#include <nlohmann/json.hpp>

namespace clerestory {
namespace {

constexpr std::chrono::milliseconds kBetweenCalls{100};
constexpr std::chrono::minutes kCallPatience{2};

// 409: the scene loads, or its curve is being measured.
bool passes(int status) {
    return status == 503 || status == 429 || status == 409;
}

Answer frame(Server& server, const std::string& body, const std::string& requestId,
             bool explained) {
    const auto begun = Clock::now();
    while (true) {
        Call call{.method = "POST",
                  .path = "/v1/frames",
                  .body = body,
                  .requestId = requestId,
                  .arrived = Clock::now(),
                  .header = [](const char* name) {
                      return std::string_view(name) == "Content-Type" ? "application/json" : "";
                  }};
        if (explained) call.query.emplace("explain", "1");
        Answer answer = answerTo(server, call);
        if (answer.status == 200) return answer;
        const bool again =
            passes(answer.status) && !server.stopping() && Clock::now() - begun < kCallPatience;
        if (!again) throw InnerFailure(std::move(answer.body));
        std::this_thread::sleep_for(kBetweenCalls);
    }
}

}  // namespace

Answer InnerFailure::answer() const {
    return {.status = nlohmann::json::parse(problem_).value("status", 500),
            .type = "application/problem+json",
            .body = problem_};
}

ExplainedFrame explainedFrame(Server& server, const std::string& body,
                              const std::string& requestId) {
    return explainedIn(frame(server, body, requestId, true));
}
Answer plainFrame(Server& server, const std::string& body, const std::string& requestId) {
    return frame(server, body, requestId, false);
}

}  // namespace clerestory
