#include "server/scene_library.h"

#include "scene/builtin/builtin_scenes.h"
#include "scene/spelling.h"
#include "server/problem.h"

#include <malloc.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cctype>

namespace clerestory {
namespace {

// Loading that ends within this is waited for; longer loading is told to the client.
constexpr std::chrono::milliseconds kPatience{1000};

// How deep below --scenes files are looked for.
constexpr int kFolderDepth = 3;

// Thrown out of an import when the server stops.
struct Stopping {};

bool importable(const std::filesystem::path& file) {
    std::string extension = file.extension().string();
    if (extension.size() < 2) return false;
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    const auto& known = importableExtensions();
    return std::find(known.begin(), known.end(), extension.substr(1)) != known.end();
}

// "My Model.glb" -> "My-Model": what needs no escaping in a URL.
std::string idFrom(const std::filesystem::path& file) {
    std::string id = file.stem().string().substr(0, 100);
    for (char& c : id) {
        const bool plain = std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '_';
        if (!plain) c = '-';
    }
    return id.empty() ? "scene" : id;
}

std::string percent(double share) {
    return std::to_string(static_cast<int>(100.0 * share)) + " %";
}

}  // namespace

std::string_view nameOf(SceneState state) {
    switch (state) {
        case SceneState::waiting:
            return "waiting";
        case SceneState::loading:
            return "loading";
        case SceneState::ready:
            return "ready";
        case SceneState::failed:
            return "failed";
    }
    return "";
}

SceneLibrary::SceneLibrary(const SceneSources& sources, RenderQueue& queue)
    : queue_(queue), import_(sources.import) {
    for (const auto& source : sources.environments) {
        auto map = std::make_shared<const EnvironmentMap>(loadEnvironment(source, import_));
        environments_[map->name] = map;
        queue_.post([map](Renderer& renderer) { renderer.addEnvironment(map); });
    }
    addBuiltins();
    std::vector<std::string> first;
    for (const std::string& source : sources.scenes) {
        const bool builtin = std::any_of(entries_.begin(), entries_.end(), [&](const auto& e) {
            return e->file.empty() && e->status.id == source;
        });
        first.push_back(builtin ? source : addFile(source));
    }
    if (!sources.folder.empty()) addFolder(sources.folder);
    if (first.empty()) first.push_back(entries_.front()->status.id);
    defaultId_ = first.front();
    for (const std::string& id : first) {
        entryFor(id).warm = true;
        askFor(entryFor(id), false);
    }
    loader_ = std::thread([this] { loadAll(); });
}

SceneLibrary::~SceneLibrary() {
    {
        const std::lock_guard lock(mutex_);
        ending_ = true;
    }
    changed_.notify_all();
    loader_.join();
}

void SceneLibrary::addBuiltins() {
    for (const BuiltinScene& scene : builtinScenes()) {
        entries_.push_back(std::make_unique<Entry>());
        entries_.back()->status.id = scene.id;
        entries_.back()->status.title = scene.title;
    }
}

std::string SceneLibrary::addFile(const std::filesystem::path& file) {
    if (!std::filesystem::is_regular_file(file)) {
        throw std::runtime_error("no scene \"" + file.string() +
                                 "\": neither a built-in scene nor a file");
    }
    const std::string wanted = idFrom(file);
    std::string id = wanted;
    const auto taken = [&] {
        return std::any_of(entries_.begin(), entries_.end(),
                           [&](const auto& e) { return e->status.id == id; });
    };
    for (int n = 2; taken(); ++n) id = wanted + "-" + std::to_string(n);
    entries_.push_back(std::make_unique<Entry>());
    entries_.back()->status.id = id;
    entries_.back()->status.title = file.filename().string();
    entries_.back()->file = file;
    return id;
}

void SceneLibrary::addFolder(const std::filesystem::path& folder) {
    if (!std::filesystem::is_directory(folder)) {
        throw std::runtime_error("no folder \"" + folder.string() + "\"");
    }
    std::vector<std::filesystem::path> files;
    using Walk = std::filesystem::recursive_directory_iterator;
    const auto options = std::filesystem::directory_options::skip_permission_denied;
    for (auto it = Walk(folder, options); it != Walk(); ++it) {
        if (it.depth() >= kFolderDepth) it.disable_recursion_pending();
        if (it->is_regular_file() && importable(it->path())) files.push_back(it->path());
    }
    std::sort(files.begin(), files.end());
    for (const auto& file : files) addFile(file);
}

std::vector<SceneStatus> SceneLibrary::all() const {
    const std::lock_guard lock(mutex_);
    std::vector<SceneStatus> list;
    for (const auto& entry : entries_) list.push_back(entry->status);
    return list;
}

SceneLibrary::Entry& SceneLibrary::entryFor(const std::string& id) {
    std::vector<std::string_view> known;
    for (const auto& entry : entries_) {
        if (entry->status.id == id) return *entry;
        known.push_back(entry->status.id);
    }
    Problem problem = notFound("There is no such scene" + didYouMean(id, known));
    problem.errors = {
        {"/scene", "is not the id of a scene" + didYouMean(id, known), listed(known)}};
    throw RequestError(std::move(problem));
}

void SceneLibrary::askFor(Entry& entry, bool first) {
    if (first && entry.status.state == SceneState::waiting && entry.asked) {
        toLoad_.erase(std::remove(toLoad_.begin(), toLoad_.end(), &entry), toLoad_.end());
        entry.asked = false;
    }
    if (entry.asked) return;
    entry.asked = true;
    toLoad_.insert(first ? toLoad_.begin() : toLoad_.end(), &entry);
    changed_.notify_all();
}

SceneStatus SceneLibrary::find(const std::string& id) {
    const std::lock_guard lock(mutex_);
    Entry& entry = entryFor(id);
    askFor(entry, true);
    return entry.status;
}

std::shared_ptr<const Scene> SceneLibrary::require(const std::string& id) {
    std::unique_lock lock(mutex_);
    Entry& entry = entryFor(id.empty() ? defaultId_ : id);
    askFor(entry, true);
    const SceneStatus& status = entry.status;
    ++entry.waiting;
    changed_.wait_for(lock, kPatience, [&] {
        return status.state == SceneState::ready || status.state == SceneState::failed || ending_;
    });
    --entry.waiting;
    if (status.state == SceneState::failed) throw RequestError(sceneFailed(status.failure));
    if (status.state != SceneState::ready) {
        throw RequestError(
            stillLoading(status.id + " is " + std::string(nameOf(status.state)) +
                         (status.progress.stage.empty() ? "" : ": " + status.progress.stage) +
                         ", " + percent(status.progress.progress) + "."));
    }
    return status.scene;
}

Scene SceneLibrary::whole(const std::string& id) {
    std::filesystem::path file;
    {
        const std::lock_guard lock(mutex_);
        file = entryFor(id).file;
    }
    Scene scene = file.empty() ? makeBuiltinScene(id).value() : importScene(file, import_);
    scene.id = id;
    requireLight(scene);
    return scene;
}

std::shared_ptr<const EnvironmentMap> SceneLibrary::environment(const std::string& name) const {
    const auto found = environments_.find(name);
    if (found != environments_.end()) return found->second;
    auto builtin = builtinEnvironment(name);
    return builtin ? std::make_shared<const EnvironmentMap>(*std::move(builtin)) : nullptr;
}

bool SceneLibrary::importing() const {
    const std::lock_guard lock(mutex_);
    return std::any_of(entries_.begin(), entries_.end(), [](const auto& entry) {
        return entry->status.state == SceneState::loading && !entry->file.empty();
    });
}

std::vector<std::string> SceneLibrary::environmentNames() const {
    std::vector<std::string> names = builtinEnvironmentNames();
    for (const auto& [name, map] : environments_) {
        if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    }
    return names;
}

std::uint64_t SceneLibrary::environmentHash(const std::string& name) const {
    const auto found = environments_.find(name);
    return found == environments_.end() ? 0 : found->second->contentHash;
}

void SceneLibrary::loadAll() {
    std::unique_lock lock(mutex_);
    for (;;) {
        changed_.wait(lock, [&] { return ending_ || !toLoad_.empty(); });
        if (ending_) return;
        Entry& entry = *toLoad_.front();
        toLoad_.pop_front();
        entry.status.state = SceneState::loading;
        lock.unlock();
        try {
            load(entry);
        } catch (const Stopping&) {
            return;
        }
        lock.lock();
    }
}

// What is told about a scene, without what only the renderer needs: nearly all of its memory.
static Scene described(Scene& scene) {
    std::vector<TextureImage> images = std::move(scene.images);
    std::vector<Vertex> vertices = std::move(scene.vertices);
    std::vector<std::uint32_t> indices = std::move(scene.indices);
    std::vector<Deformation> deformations = std::move(scene.deformations);
    Scene result = scene;
    for (TextureImage& image : images) {
        std::vector<std::uint8_t> texels = std::exchange(image.texels, {});
        result.images.push_back(image);
        image.texels = std::move(texels);
    }
    scene.images = std::move(images);
    scene.vertices = std::move(vertices);
    scene.indices = std::move(indices);
    scene.deformations = std::move(deformations);
    return result;
}

void SceneLibrary::load(Entry& entry) {
    const auto start = Clock::now();
    const std::string id = entry.status.id;
    std::shared_ptr<Scene> full;
    try {
        full = std::make_shared<Scene>(made(entry));
    } catch (const std::exception& error) {
        spdlog::error("scene {}: {}", id, error.what());
        const std::lock_guard lock(mutex_);
        entry.status.state = SceneState::failed;
        entry.status.failure = dynamic_cast<const ImportError*>(&error)
                                   ? error.what()
                                   : "The scene could not be made.";
        changed_.notify_all();
        return;
    }
    const auto scene = std::make_shared<const Scene>(described(*full));
    const std::size_t vertices = full->vertices.size();
    queue_.post([full](Renderer& renderer) {
        renderer.addScene(std::move(*full));
        malloc_trim(0);  // reading a large scene leaves the heap full of holes
    });
    const std::lock_guard lock(mutex_);
    if (ending_) return;  // a start that failed says why and nothing else
    spdlog::info("scene {}: {} triangles in {:.0f} ms", id, triangleCount(*scene),
                 millisecondsSince(start));
    // A frame that somebody waits for warms what it needs, sooner.
    if (entry.warm && entry.waiting == 0) {
        queue_.post([id](Renderer& renderer) { renderer.warm(id); });
    }
    entry.status.scene = scene;
    entry.status.vertices = vertices;
    entry.status.title = scene->title.empty() ? entry.status.title : scene->title;
    entry.status.progress = {.stage = "", .progress = 1.0};
    entry.status.state = SceneState::ready;
    changed_.notify_all();
}

Scene SceneLibrary::made(Entry& entry) {
    Scene scene;
    if (entry.file.empty()) {
        scene = makeBuiltinScene(entry.status.id).value();
    } else {
        scene = importScene(entry.file, import_, [&](const ImportProgress& progress) {
            const std::lock_guard lock(mutex_);
            if (ending_) throw Stopping{};
            entry.status.progress = progress;
        });
    }
    scene.id = entry.status.id;
    requireLight(scene);
    return scene;
}

// A side file may name a map that this server was not started with.
void SceneLibrary::requireLight(Scene& scene) const {
    if (environment(scene.environment)) return;
    scene.warnings.push_back({"unknownEnvironment", scene.environment,
                              "no environment map of that name is loaded; 'sky' lights the scene"});
    scene.environment = "sky";
    updateContentHash(scene);
}

}  // namespace clerestory
