#include "server/api/uploads.h"

#include "server/base/problem.h"

#include <algorithm>
#include <cstring>
#include <optional>
#include <set>
#include <thread>
#include <vector>

namespace clerestory {
namespace {

// Added to the time that one import may take: another import may run first.
constexpr std::chrono::seconds kExtraPatience{10};
constexpr std::chrono::milliseconds kPollInterval{20};
constexpr std::size_t kMaxTitle = 100;

// The accepted media types. A page of another origin needs a CORS preflight for each of them.
struct MediaType {
    const char* name;
    std::set<std::string> kinds;  // of UploadStore::kindOf(); empty: any
};
const std::vector<MediaType> kSceneTypes = {
    {"application/octet-stream", {}},
    {"model/gltf-binary", {"glb"}},
    {"model/gltf+json", {"gltf"}},
    {"model/stl", {"stl"}},
    {"model/vnd.collada+xml", {"dae"}},
    {"application/zip", {"zip"}},
    {"application/x-zip-compressed", {"zip"}},
    {"application/x-tar", {"tar"}},
    {"application/gzip", {"tgz"}},
    {"application/x-gzip", {"tgz"}},
    {"application/x-gtar", {"tar", "tgz"}},
};
const std::vector<MediaType> kMapTypes = {
    {"application/octet-stream", {}}, {"image/vnd.radiance", {"hdr"}},
    {"image/x-exr", {"exr"}},         {"image/ktx", {"ktx"}},
    {"image/ktx2", {"ktx2"}},         {"image/vnd-ms.dds", {"dds"}},
};

// As sceneFailed(), without the error of a frame request's field.
RequestError noScene(std::string detail, std::string reason) {
    Problem problem = sceneFailed(std::move(detail), std::move(reason));
    problem.errors.clear();
    return RequestError(std::move(problem));
}

UploadStore& storeOf(const UploadRoutes& routes) {
    if (routes.store) return *routes.store;
    throw RequestError(
        forbidden("Uploads are not allowed; the server's option --uploads allows them."));
}

std::string mediaTypeOf(const Call& call) {
    std::string type = call.header("Content-Type");
    type = type.substr(0, type.find(';'));
    while (!type.empty() && type.back() == ' ') type.pop_back();
    std::transform(type.begin(), type.end(), type.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return type;
}

// The kind by the content; the Content-Type must agree. Empty if it is none of these types.
std::string kindOf(const Call& call, const std::vector<MediaType>& types) {
    const std::string type = mediaTypeOf(call);
    const auto known = std::find_if(types.begin(), types.end(),
                                    [&](const MediaType& m) { return m.name == type; });
    if (known == types.end()) return "";
    const std::string kind = UploadStore::kindOf(call.body);
    return known->kinds.empty() || known->kinds.contains(kind) ? kind : "";
}

std::string requireSceneKind(const Call& call) {
    std::string kind = kindOf(call, kSceneTypes);
    if (kind.empty()) throw RequestError(notSceneType());
    if (!UploadStore::isMapKind(kind)) return kind;
    Problem problem = notSceneType();
    problem.detail = "This is an environment map (." + kind + "); POST it to /v1/environments.";
    throw RequestError(std::move(problem));
}

std::string requireMapKind(const Call& call) {
    std::string kind = kindOf(call, kMapTypes);
    if (!UploadStore::isMapKind(kind)) throw RequestError(notMapType());
    return kind;
}

// A .glb has its length in its header, so that a truncated file is found at once.
void requireWhole(const std::string& kind, const std::string& content) {
    if (kind != "glb") return;
    std::uint32_t length = 0;
    if (content.size() >= 12) std::memcpy(&length, content.data() + 8, sizeof length);
    if (length != content.size()) {
        throw noScene("The length of the .glb differs from that in its header.", "malformed");
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

std::string scenePath(const std::string& id) {
    return "/v1/scenes/" + id;
}

bool prefersAsync(const Call& call) {
    return call.header("Prefer").find("respond-async") != std::string::npos;
}

// Waits until the scene is loaded, as long as the client, the server and the time limit permit.
// Waiting occupies a thread, so that few calls may do so at once.
Answer awaitScene(const UploadRoutes& routes, const Call& call, const std::string& id, bool isNew) {
    const auto until = Clock::now() + routes.importTime + kExtraPatience;
    std::optional<Holdings::Held> share;
    if (!prefersAsync(call)) share = routes.holdings.take(Pool::waits, call.client, 1);
    for (;;) {
        SceneReport scene = routes.backend.sceneReport(id);
        if (scene.state == SceneState::failed) throw noScene(scene.failure, scene.reason);
        const bool ready = scene.state == SceneState::ready || scene.isKnown;
        const bool cancelled = call.cancellation && call.cancellation->cancelled();
        if (!ready && share && !cancelled && !routes.stopping && Clock::now() < until) {
            std::this_thread::sleep_for(kPollInterval);
            continue;
        }
        Answer answer{.status = !ready  ? 202
                                : isNew ? 201
                                        : 200,
                      .type = "application/json",
                      .body = std::move(scene.description),
                      .headers = {{"Location", scenePath(id)}},
                      .worker = scene.worker};
        if (!ready) answer.headers.emplace_back("Retry-After", "1");
        return answer;
    }
}

Answer postScene(const UploadRoutes& routes, const Call& call) {
    UploadStore& store = storeOf(routes);
    const std::string title = titleIn(call);
    const std::string kind = requireSceneKind(call);
    requireWhole(kind, call.body);
    const std::string id = UploadStore::idOf(call.body);
    const auto stored = store.find(id);
    const bool isNew = !stored || !stored->failure.empty();
    if (!stored) store.add(kind, title.empty() ? "scene." + kind : title, call.body);
    // A repeated upload of a scene that failed is tried again.
    if (stored && isNew) store.setFailure(id, "", "");
    return awaitScene(routes, call, id, isNew);
}

// Asks the renderer until it has loaded the map or refuses it, as long as the client, the server
// and the time limit permit.
Answer awaitMap(const UploadRoutes& routes, const Call& call, const std::string& path) {
    const auto until = Clock::now() + routes.importTime + kExtraPatience;
    for (;;) {
        Answer answer = routes.backend.answer({.method = "GET",
                                               .path = path,
                                               .query = {},
                                               .target = {},
                                               .body = {},
                                               .requestId = call.requestId,
                                               .arrived = call.arrived,
                                               .header = call.header,
                                               .client = call.client,
                                               .cancellation = call.cancellation});
        const bool loads = answer.problem && answer.problem->code == ProblemCode::stillLoading;
        const bool cancelled = call.cancellation && call.cancellation->cancelled();
        if (!loads || cancelled || routes.stopping || Clock::now() >= until) return answer;
        std::this_thread::sleep_for(kPollInterval);
    }
}

// The renderer loads the map, which shows whether it is usable, and describes it.
Answer postMap(const UploadRoutes& routes, const Call& call) {
    UploadStore& store = storeOf(routes);
    const std::string title = titleIn(call);
    const std::string kind = requireMapKind(call);
    const std::string id = UploadStore::idOf(call.body);
    const bool isNew = !store.find(id);
    if (isNew) store.add(kind, title.empty() ? "map." + kind : title, call.body);
    const std::string path = "/v1/environments/" + id;
    Answer answer = awaitMap(routes, call, path);
    if (answer.problem && answer.problem->code == ProblemCode::mapFailed) store.remove(id);
    if (answer.problem) return answer;
    answer.status = isNew ? 201 : 200;
    answer.headers.emplace_back("Location", path);
    return answer;
}

// The renderer first: it refuses what is not an upload.
Answer deleteUpload(const UploadRoutes& routes, const Call& call) {
    UploadStore& store = storeOf(routes);
    const std::string id = call.path.substr(call.path.rfind('/') + 1);
    Answer answer = routes.backend.answer(call);
    if (!answer.problem) store.remove(id);
    return answer;
}

}  // namespace

void addRoutes(Routes& routes, const UploadRoutes& components) {
    routes.add("/v1/scenes", "POST", components, postScene);
    routes.add("/v1/scenes/{id}", "DELETE", components, deleteUpload);
    routes.add("/v1/environments", "POST", components, postMap);
    routes.add("/v1/environments/{map}", "DELETE", components, deleteUpload);
}

}  // namespace clerestory
