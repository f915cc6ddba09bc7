#include "server/api/explained.h"

#include <stdexcept>
#include <tuple>

namespace clerestory {
namespace {

constexpr std::string_view kTypePrefix = "multipart/mixed; boundary=";

std::string part(const std::string& boundary, const std::string& head, const std::string& bytes) {
    return "--" + boundary + "\r\nContent-Type: " + head +
           "\r\nContent-Length: " + std::to_string(bytes.size()) + "\r\n\r\n" + bytes + "\r\n";
}

// A header's quoted string; names come from files.
std::string quoted(std::string name) {
    std::erase_if(name,
                  [](unsigned char c) { return c < 32 || c >= 127 || c == '"' || c == '\\'; });
    return '"' + name + '"';
}

// Takes one part off `rest`.
std::pair<std::string, std::string> takePart(std::string_view& rest) {
    const auto field = [&](std::string_view name) {
        const std::size_t begin = rest.find(name), end = rest.find("\r\n", begin);
        if (end == std::string_view::npos) throw std::runtime_error("not an explained frame");
        return rest.substr(begin + name.size(), end - begin - name.size());
    };
    const std::string type(field("Content-Type: "));
    const std::size_t length = std::stoull(std::string(field("Content-Length: ")));
    rest.remove_prefix(rest.find("\r\n\r\n") + 4);
    if (length > rest.size()) throw std::runtime_error("an explained frame is truncated");
    const std::string bytes(rest.substr(0, length));
    rest.remove_prefix(length);
    return {type, bytes};
}

}  // namespace

void putExplained(Answer& answer, const ExplainedFrame& frame, const std::string& boundary) {
    answer.body =
        part(boundary, frame.type, frame.picture) + part(boundary, "application/json", frame.plan);
    for (const ExplainedFrame::Map& map : frame.maps) {
        const std::string named = "\r\nContent-Disposition: attachment; name=" + quoted(map.target);
        answer.body += part(boundary, "image/jpeg" + named, map.jpeg);
    }
    answer.body += "--" + boundary + "--\r\n";
    answer.type = std::string(kTypePrefix) + boundary;
}

ExplainedFrame explainedIn(const Answer& answer) {
    if (!answer.type.starts_with(kTypePrefix)) throw std::runtime_error("not an explained frame");
    std::string_view rest = answer.body;
    ExplainedFrame frame;
    std::tie(frame.type, frame.picture) = takePart(rest);
    frame.plan = takePart(rest).second;
    return frame;
}

}  // namespace clerestory
