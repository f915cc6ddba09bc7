// Layout of an entry's file: header, dependencies, blob. The header has the sizes of the other two
// and the checksum of the dependencies; the blob has its own.
#include "scene/import/cache/scene_cache.h"

#include "scene/hash.h"
#include "scene/import/cache/blob.h"

#include <openssl/evp.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

namespace clerestory {
namespace {

namespace fs = std::filesystem;

constexpr const char* kExtension = ".scene";
constexpr std::size_t kMaxDependencies = 8192, kMaxQueued = 2;

struct EntryHeader {
    char magic[8] = {'C', 'L', 'C', 'A', 'C', 'H', 'E', '\0'};
    std::uint32_t version = 1;
    std::uint32_t dependencies = 0;
    std::uint64_t dependencyBytes = 0, dependencyHash = 0, blobBytes = 0;
};

std::string sha256(std::string_view first, std::string_view second) {
    unsigned char digest[EVP_MAX_MD_SIZE];
    unsigned size = 0;
    const std::unique_ptr<EVP_MD_CTX, void (*)(EVP_MD_CTX*)> hash(EVP_MD_CTX_new(),
                                                                  EVP_MD_CTX_free);
    const bool made = hash && EVP_DigestInit_ex(hash.get(), EVP_sha256(), nullptr) == 1 &&
                      EVP_DigestUpdate(hash.get(), first.data(), first.size()) == 1 &&
                      EVP_DigestUpdate(hash.get(), second.data(), second.size()) == 1 &&
                      EVP_DigestFinal_ex(hash.get(), digest, &size) == 1;
    if (!made) throw std::bad_alloc();
    std::string hex;
    for (unsigned i = 0; i < size; ++i) {
        hex += "0123456789abcdef"[digest[i] >> 4];
        hex += "0123456789abcdef"[digest[i] & 15];
    }
    return hex;
}

// The present state of a file, from the same query that recorded `known`.
FileDependency currentState(const SceneFolder& folder, const FileDependency& known) {
    FileDependency now{.name = known.name};
    if (known.state == FileDependency::State::present) {
        if (folder.has(known.name)) now.state = FileDependency::State::present;
        return now;
    }
    return folder.dependency(known.name);
}

std::string packed(const std::vector<FileDependency>& dependencies) {
    std::string text;
    const auto add = [&](const auto& value) {
        text.append(reinterpret_cast<const char*>(&value), sizeof value);
    };
    for (const FileDependency& d : dependencies) {
        add(d.state);
        add(d.low);
        add(d.high);
        add(static_cast<std::uint32_t>(d.name.size()));
        text += d.name;
    }
    return text;
}

// Nothing unless the text is the output of packed() for `count` dependencies.
std::optional<std::vector<FileDependency>> unpackedDependencies(std::string_view text,
                                                                std::uint32_t count) {
    std::vector<FileDependency> list;
    bool valid = count <= kMaxDependencies;
    const auto take = [&](auto& value) {
        valid = valid && text.size() >= sizeof value;
        if (!valid) return;
        std::memcpy(&value, text.data(), sizeof value);
        text.remove_prefix(sizeof value);
    };
    for (std::uint32_t i = 0; valid && i < count; ++i) {
        FileDependency& d = list.emplace_back();
        std::uint32_t size = 0;
        take(d.state);
        take(d.low);
        take(d.high);
        take(size);
        valid = valid && size <= text.size() && d.state <= FileDependency::State::read;
        if (!valid) break;
        d.name = text.substr(0, size);
        text.remove_prefix(size);
    }
    if (!valid || !text.empty()) return std::nullopt;
    return list;
}

// The scene of an entry, if the entry is complete and its dependencies are unchanged.
std::optional<Scene> validScene(CacheReader& in, const SceneCache::Key& key) {
    EntryHeader header;
    const EntryHeader expected;
    if (!in.read(&header, sizeof header)) return std::nullopt;
    if (std::memcmp(header.magic, expected.magic, sizeof header.magic) != 0 ||
        header.version != expected.version || header.dependencyBytes > in.left() ||
        header.blobBytes != in.left() - header.dependencyBytes) {
        return std::nullopt;
    }
    std::string list(static_cast<std::size_t>(header.dependencyBytes), '\0');
    if (!in.read(list.data(), list.size())) return std::nullopt;
    if (hashOfBytes(std::as_bytes(std::span(list))) != header.dependencyHash) return std::nullopt;
    const auto dependencies = unpackedDependencies(list, header.dependencies);
    if (!dependencies) return std::nullopt;
    const SceneFolder folder(key.scene.parent_path(), key.limits.fileBytes, key.limits.maxFiles);
    for (const FileDependency& known : *dependencies) {
        const bool unchanged = known.name == key.content.name
                                   ? known == key.content
                                   : currentState(folder, known) == known;
        if (!unchanged) return std::nullopt;
    }
    Scene scene = readScene(
        [&](void* to, std::size_t count) {
            if (!in.read(to, count)) throw BlobError("the file cannot be read");
        },
        header.blobBytes);
    if (!sceneProblems(scene).empty()) return std::nullopt;
    return scene;
}

}  // namespace

std::optional<SceneCache::Key> SceneCache::keyOf(const fs::path& scene, const ImportLimits& limits,
                                                 const std::string& sceneOfFile) const {
    try {
        const SceneFolder folder(scene.parent_path(), limits.fileBytes, limits.maxFiles);
        Key key{.scene = scene, .limits = limits};
        key.content.name = scene.filename().string();
        const std::string content = folder.read(key.content.name);
        setContent(key.content, content);
        key.hash = sha256(options_.version + '\n' + key.content.name + '\n' + encoded(limits) +
                              '\n' + sceneOfFile + '\n',
                          content);
        return key;
    } catch (const ImportError&) {
        return std::nullopt;
    }
}

fs::path SceneCache::fileOf(const Key& key) const {
    return options_.folder / (key.hash + kExtension);
}

std::optional<Scene> SceneCache::find(const Key& key) {
    try {
        auto in = CacheReader::open(fileOf(key), options_.maxBytes);
        return in ? validScene(*in, key) : std::nullopt;
    } catch (const BlobError&) {
    } catch (const ImportError&) {
    } catch (const std::bad_alloc&) {
    }
    return std::nullopt;
}

void SceneCache::store(const Key& key, const std::vector<FileDependency>& dependencies,
                       std::span<const std::byte> blob, std::shared_ptr<const void> owner) {
    // The scene file may have changed between keyOf() and the import.
    const bool same =
        std::find(dependencies.begin(), dependencies.end(), key.content) != dependencies.end();
    if (!same || dependencies.size() > kMaxDependencies || blob.size() > options_.maxBytes / 2) {
        return;
    }
    const std::string list = packed(dependencies);
    EntryHeader header;
    header.dependencies = static_cast<std::uint32_t>(dependencies.size());
    header.dependencyBytes = list.size();
    header.dependencyHash = hashOfBytes(std::as_bytes(std::span(list)));
    header.blobBytes = blob.size();
    std::string head(reinterpret_cast<const char*>(&header), sizeof header);
    const std::lock_guard lock(mutex_);
    if (queue_.size() >= kMaxQueued) return;  // each one holds a whole scene in memory
    queue_.push_back({fileOf(key), head + list, blob, std::move(owner)});
    if (!writer_.joinable()) writer_ = std::thread([this] { runWriter(); });
    changed_.notify_all();
}

SceneCache::~SceneCache() {
    {
        const std::lock_guard lock(mutex_);
        ending_ = true;
    }
    changed_.notify_all();
    if (writer_.joinable()) writer_.join();
}

void SceneCache::flush() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return queue_.empty() && !writing_; });
}

void SceneCache::runWriter() {
    std::unique_lock lock(mutex_);
    for (;;) {
        changed_.wait(lock, [&] { return ending_ || !queue_.empty(); });
        if (queue_.empty()) return;
        {
            const Entry entry = std::move(queue_.front());
            queue_.pop_front();
            writing_ = true;
            lock.unlock();
            write(entry);
        }
        lock.lock();
        writing_ = false;
        changed_.notify_all();
    }
}

void SceneCache::write(const Entry& entry) {
    if (writeCacheFile(entry.file, {std::as_bytes(std::span(entry.head)), entry.blob})) {
        failureReported_ = false;
        return trimCacheFolder(options_.folder, kExtension, options_.maxBytes);
    }
    if (std::exchange(failureReported_, true) || !options_.reportFailure) return;
    options_.reportFailure("Imported scenes cannot be cached in \"" + options_.folder.string() +
                           "\": " + std::strerror(errno));
}

}  // namespace clerestory
