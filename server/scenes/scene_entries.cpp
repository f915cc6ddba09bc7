#include "server/scenes/scene_entries.h"

#include "scene/builtin/builtin_scenes.h"

#include <algorithm>
#include <cctype>
#include <unordered_set>

namespace clerestory {
namespace {

// How many levels of subfolders of --scenes are searched.
constexpr int kFolderDepth = 3;

bool importable(const std::filesystem::path& file) {
    std::string extension = file.extension().string();
    if (extension.size() < 2) return false;
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    const auto& known = importableExtensions();
    return std::find(known.begin(), known.end(), extension.substr(1)) != known.end();
}

// "My Model" -> "My-Model", which needs no escaping in a URL.
std::string idFrom(const std::string& name) {
    std::string id = name.substr(0, 100);
    for (char& c : id) {
        const bool plain = std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '_';
        if (!plain) c = '-';
    }
    return id.empty() ? "scene" : id;
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

SceneBytes bytesOf(const Scene& scene) {
    SceneBytes bytes{.meshes = 2 * (scene.vertices.size() * sizeof(Vertex) +
                                    scene.indices.size() * sizeof(std::uint32_t))};
    for (const TextureImage& image : scene.images) bytes.textures += image.texels.size();
    return bytes;
}

void lightWithSky(Scene& scene) {
    scene.warnings.push_back({"unknownEnvironment", scene.environment,
                              "no environment map of that name is loaded; 'sky' lights the scene"});
    scene.environment = "sky";
    updateContentHash(scene);
}

SceneEntries::SceneEntries(const SceneSources& sources) {
    for (const BuiltinScene& scene : builtinScenes()) add(scene.id, scene.title, {});
    for (const std::string& source : sources.scenes) {
        const Entry builtin = find(source);
        first_.push_back(builtin && builtin->file.empty() ? builtin : addFile(sceneSource(source)));
    }
    if (!sources.folder.empty()) addFolder(sources.folder);
    if (first_.empty()) first_.push_back(entries_.front());
}

SceneEntries::Entry SceneEntries::add(const std::string& id, const std::string& title,
                                      const std::filesystem::path& file) {
    auto entry = std::make_shared<SceneEntry>();
    entry->status.id = id;
    entry->status.title = title;
    entry->file = file;
    entry->fileId = id;
    entries_.push_back(entry);
    return entry;
}

SceneEntries::Entry SceneEntries::addFile(const SceneSource& source) {
    const auto& [file, scene] = source;
    if (!std::filesystem::is_regular_file(file)) {
        throw std::runtime_error("no scene \"" + file.string() +
                                 "\": neither a built-in scene nor a file");
    }
    const std::string wanted = idFrom(file.stem().string() + (scene.empty() ? "" : "-" + scene));
    std::string id = wanted;
    for (int n = 2; find(id); ++n) id = wanted + "-" + std::to_string(n);
    const Entry entry = add(id, file.filename().string(), file);
    entry->sceneOfFile = scene;
    return entry;
}

void SceneEntries::addFolder(const std::filesystem::path& folder) {
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
    for (const auto& file : files) addFile({file, ""});
}

std::vector<SceneEntries::Entry> SceneEntries::listed() const {
    std::vector<Entry> list;
    for (const Entry& entry : entries_) {
        if (!entry->isDeleted) list.push_back(entry);
    }
    return list;
}

SceneEntries::Entry SceneEntries::find(const std::string& id) const {
    const auto found = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& e) {
        return e->status.id == id && !e->isDeleted;
    });
    return found == entries_.end() ? nullptr : *found;
}

std::vector<SceneEntries::Entry> SceneEntries::updateUploads(const std::vector<Upload>& uploads) {
    std::unordered_set<std::string_view> stored;
    for (const Upload& upload : uploads) stored.insert(upload.id);
    std::vector<Entry> removed;
    for (const Entry& entry : listed()) {
        if (entry->status.uploaded && !stored.contains(entry->fileId)) removed.push_back(entry);
    }
    for (const Upload& upload : uploads) {
        if (upload.isMap) continue;
        const auto same = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& e) {
            return e->status.uploaded && e->status.id == upload.id;
        });
        const bool isNew = same == entries_.end();
        const Entry entry = isNew ? add(upload.id, upload.title, upload.file) : *same;
        entry->isDeleted = false;
        SceneStatus& status = entry->status;
        if (isNew) status.uploaded = true;  // only now: the loader reads it without the lock
        // A repeated upload clears the failure, so that the scene is tried again.
        const bool known = status.state == SceneState::failed;
        const bool fails = !upload.failure.empty();
        if (known == fails || (fails && status.state != SceneState::waiting)) continue;
        status.state = fails ? SceneState::failed : SceneState::waiting;
        status.failure = upload.failure;
        status.reason = upload.reason;
        entry->isRequested = fails;
    }
    return removed;
}

SceneEntries::Entry SceneEntries::findFile(const std::string& id) const {
    const std::size_t colon = id.rfind(':');
    if (colon == std::string::npos) return nullptr;
    const bool number =
        colon + 1 < id.size() && id.find_first_not_of("0123456789", colon + 1) == std::string::npos;
    const Entry file = number ? find(id.substr(0, colon)) : nullptr;
    return file && !file->file.empty() ? file : nullptr;
}

SceneEntries::Entry SceneEntries::makeOther(const SceneEntry& file, std::size_t number) {
    const SceneOfFile& scene = file.status.scenesOfFile->at(number);
    auto other = std::make_shared<SceneEntry>();
    other->status.id = scene.id;
    other->status.title = file.status.title + ": " + scene.name;
    other->status.uploaded = file.status.uploaded;
    other->status.scenesOfFile = file.status.scenesOfFile;
    other->file = file.file;
    other->sceneOfFile = std::to_string(number);
    other->fileId = file.fileId;
    return other;
}

void SceneEntries::addScenesOfFile(const Entry& entry, const Scene& known) {
    if (known.scenesOfFile.empty() || entry->fileId != entry->status.id) return;
    const auto scenes = std::make_shared<ScenesOfFile>();
    for (std::size_t i = 0; i < known.scenesOfFile.size(); ++i) {
        const std::string number = i == known.sceneOfFile ? "" : ":" + std::to_string(i);
        scenes->push_back({entry->fileId + number, known.scenesOfFile[i]});
    }
    entry->status.scenesOfFile = scenes;
    std::unordered_set<std::string_view> present{entry->status.id};
    for (const Entry& one : entries_) {
        if (one->fileId != entry->fileId || one->isDeleted) continue;
        one->status.scenesOfFile = scenes;
        present.insert(one->status.id);
    }
    std::vector<Entry> others;
    for (std::size_t i = 0; i < scenes->size(); ++i) {
        if (!present.contains((*scenes)[i].id)) others.push_back(makeOther(*entry, i));
    }
    const auto place = std::find(entries_.begin(), entries_.end(), entry) + 1;
    entries_.insert(place, others.begin(), others.end());
}

void SceneEntries::remove(const Entry& entry) {
    std::erase(entries_, entry);
}

std::string firstSourceOf(const SceneSources& sources) {
    return sources.scenes.empty() ? "chapel" : sources.scenes.front();
}

}  // namespace clerestory
