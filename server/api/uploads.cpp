#include "server/api/uploads.h"

#include "server/base/problem.h"
#include "server/server.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstring>
#include <set>
#include <thread>

namespace clerestory {
namespace {

using nlohmann::json;

// Beyond the time that one import may take: another one may be under way.
constexpr std::chrono::seconds kPatienceBesideImport{10};
constexpr std::chrono::milliseconds kBetweenLooks{20};
constexpr std::size_t kMaxTitle = 100;

// Of what may be sent; none is a type that a page elsewhere can send without being asked whether it
// may.
struct MediaType {
    const char* name;
    std::set<std::string> kinds;  // of UploadStore::kindOf(); empty: any
};
const MediaType kMediaTypes[] = {
    {"application/octet-stream", {}},
    {"model/gltf-binary", {"glb"}},
    {"model/gltf+json", {"gltf"}},
    {"application/zip", {"zip"}},
    {"application/x-zip-compressed", {"zip"}},
    {"application/x-tar", {"tar"}},
    {"application/gzip", {"tgz"}},
    {"application/x-gzip", {"tgz"}},
    {"application/x-gtar", {"tar", "tgz"}},
};

// Without the field of a frame's request.
RequestError noScene(std::string detail, std::string reason) {
    Problem problem = sceneFailed(std::move(detail), std::move(reason));
    problem.errors.clear();
    return RequestError(std::move(problem));
}

UploadStore& storeOf(Server& server) {
    if (UploadStore* store = server.uploads()) return *store;
    throw RequestError(
        forbidden("Uploads are off. Whoever runs the server can allow them with --uploads."));
}

std::string mediaTypeOf(const Call& call) {
    std::string type = call.header("Content-Type");
    type = type.substr(0, type.find(';'));
    while (!type.empty() && type.back() == ' ') type.pop_back();
    std::transform(type.begin(), type.end(), type.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return type;
}

// By its content; what the client says of it must agree.
std::string requireKind(const Call& call) {
    const std::string type = mediaTypeOf(call);
    const auto* known = std::find_if(std::begin(kMediaTypes), std::end(kMediaTypes),
                                     [&](const MediaType& m) { return m.name == type; });
    if (known == std::end(kMediaTypes)) throw RequestError(notSceneType());
    const std::string kind = UploadStore::kindOf(call.body);
    if (kind.empty() || (!known->kinds.empty() && !known->kinds.contains(kind))) {
        throw RequestError(notSceneType());
    }
    return kind;
}

// Its header says how long it is, so that half of one is known at once.
void requireWhole(const std::string& kind, const std::string& content) {
    if (kind != "glb") return;
    std::uint32_t length = 0;
    if (content.size() >= 12) std::memcpy(&length, content.data() + 8, sizeof length);
    if (length != content.size()) {
        throw noScene("The .glb is not as long as its header says.", "malformed");
    }
}

std::string titleIn(const Call& call) {
    std::string title;
    for (const auto& [name, value] : call.query) {
        if (name != "title") {
            throw RequestError(
                invalidFields({{"/" + name.substr(0, 64), "is not a known query name", "title"}}));
        }
        title = value.substr(0, kMaxTitle);
    }
    for (char& c : title) {
        if (static_cast<unsigned char>(c) < 32 || c == 127) c = ' ';
    }
    return title;
}

std::string placeOf(const std::string& id) {
    return "/v1/scenes/" + id;
}

// What whoever draws says of the scene; asking makes it load.
Answer described(Server& server, const Call& call, const std::string& id) {
    return server.ask({.method = "GET",
                       .path = placeOf(id),
                       .requestId = call.requestId,
                       .arrived = Clock::now(),
                       .header = [](const char*) { return std::string(); },
                       .client = call.client,
                       .cancellation = nullptr});
}

bool mayLeave(const Call& call) {
    return call.header("Prefer").find("respond-async") != std::string::npos;
}

// The answer to whoever sent it: as far as it has come in the time that there is.
Answer settled(Server& server, const Call& call, const std::string& id, bool isNew) {
    const auto until = Clock::now() + server.uploadLimits().wallClock + kPatienceBesideImport;
    for (;;) {
        Answer answer = described(server, call, id);
        if (answer.status != 200) return answer;
        const json scene = json::parse(answer.body);
        const std::string state = scene.at("state");
        if (state == "failed") {
            throw noScene(scene.value("failure", ""), scene.value("reason", ""));
        }
        const bool ready = state == "ready" || scene.contains("triangles");
        const bool left = call.cancellation && call.cancellation->cancelled();
        if (!ready && !mayLeave(call) && !left && !server.stopping() && Clock::now() < until) {
            std::this_thread::sleep_for(kBetweenLooks);
            continue;
        }
        answer.status = !ready ? 202 : isNew ? 201 : 200;
        answer.headers.emplace_back("Location", placeOf(id));
        if (!ready) answer.headers.emplace_back("Retry-After", "1");
        return answer;
    }
}

}  // namespace

Answer postScene(Server& server, const Call& call) {
    UploadStore& store = storeOf(server);
    const std::string title = titleIn(call);
    const std::string kind = requireKind(call);
    requireWhole(kind, call.body);
    const std::string id = UploadStore::idOf(call.body);
    const auto there = store.find(id);
    const bool isNew = !there || !there->failure.empty();
    if (!there) store.add(kind, title.empty() ? "scene." + kind : title, call.body);
    if (there && isNew)
        store.setFailure(id, "", "");  // whoever sends it again wants it tried again
    return settled(server, call, id, isNew);
}

Answer deleteScene(Server& server, const Call& call) {
    UploadStore& store = storeOf(server);
    const std::string id = call.path.substr(call.path.rfind('/') + 1);
    const Answer answer = server.ask(call);  // first, so that what is no upload is told
    if (answer.status == 204) store.remove(id);
    return answer;
}

}  // namespace clerestory
