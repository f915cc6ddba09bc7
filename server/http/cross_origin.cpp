#include "server/http/cross_origin.h"

#include <algorithm>

namespace clerestory {

bool CrossOrigin::allows(const std::string& origin) const {
    return !origin.empty() &&
           std::any_of(origins_.begin(), origins_.end(),
                       [&](const std::string& o) { return o == "*" || o == origin; });
}

void CrossOrigin::permit(const std::string& origin, Answer& answer) const {
    if (origins_.empty()) return;
    // A cache must not give one origin the answer to another.
    answer.headers.emplace_back("Vary", "Origin");
    if (allows(origin)) answer.headers.emplace_back("Access-Control-Allow-Origin", origin);
}

std::optional<Answer> CrossOrigin::preflight(const Call& call) const {
    const std::string origin = call.header("Origin");
    if (call.method != "OPTIONS" || call.header("Access-Control-Request-Method").empty() ||
        !allows(origin)) {
        return std::nullopt;
    }
    Answer answer{.status = 204};
    permit(origin, answer);
    answer.headers.emplace_back("Access-Control-Allow-Methods", "GET, HEAD, POST, PUT, DELETE");
    // The asterisk does not include Authorization.
    answer.headers.emplace_back("Access-Control-Allow-Headers", "Authorization, *");
    answer.headers.emplace_back("Access-Control-Max-Age", "3600");
    return answer;
}

Answer CrossOrigin::permitted(const Call& call, Answer answer) const {
    const std::string origin = call.header("Origin");
    permit(origin, answer);
    if (allows(origin)) answer.headers.emplace_back("Access-Control-Expose-Headers", "*");
    return answer;
}

}  // namespace clerestory
