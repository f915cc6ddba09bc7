#include "server/api/explained.h"

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

}  // namespace clerestory
