#include "server/api/page.h"

#include "embedded_webFiles.h"

namespace clerestory {
namespace {

const char* typeOf(std::string_view name) {
    if (name.ends_with(".html")) return "text/html; charset=utf-8";
    if (name.ends_with(".js")) return "text/javascript; charset=utf-8";
    if (name.ends_with(".css")) return "text/css; charset=utf-8";
    if (name.ends_with(".svg")) return "image/svg+xml";
    return "application/octet-stream";
}

}  // namespace

std::optional<Answer> pageFile(const std::string& path) {
    const std::string name = path == "/" ? "index.html" : path.substr(1);
    for (const EmbeddedFile& file : webFiles()) {
        if (file.name != name) continue;
        return Answer{.type = typeOf(file.name), .body = std::string(file.content)};
    }
    return std::nullopt;
}

}  // namespace clerestory
