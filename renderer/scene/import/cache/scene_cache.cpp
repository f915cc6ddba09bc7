// Layout of an entry's file: header, dependencies, blob. The header has the sizes of the other two
// and the checksum of the dependencies; the blob has its own.
#include "scene/import/cache/scene_cache.h"

#include "scene/hash.h"
#include "scene/import/cache/blob.h"

#include <openssl/evp.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

namespace clerestory {
namespace {

namespace fs = std::filesystem;

constexpr const char* kTemporary = ".unfinished";

struct CacheDescriptor {
    explicit CacheDescriptor(int number) : value(number) {}
    ~CacheDescriptor() {
        if (value >= 0) close(value);
    }
    CacheDescriptor(const CacheDescriptor&) = delete;
    CacheDescriptor& operator=(const CacheDescriptor&) = delete;
    const int value;
};

bool writeAll(int file, std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
        const ssize_t n = ::write(file, bytes.data(), bytes.size());
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) return false;
        bytes = bytes.subspan(static_cast<std::size_t>(n));
    }
    return true;
}

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
std::optional<Scene> validScene(std::span<const std::byte> bytes, const SceneCache::Key& key) {
    EntryHeader header;
    const EntryHeader expected;
    if (bytes.size() < sizeof header) return std::nullopt;
    std::memcpy(&header, bytes.data(), sizeof header);
    const auto rest = bytes.subspan(sizeof header);
    if (std::memcmp(header.magic, expected.magic, sizeof header.magic) != 0 ||
        header.version != expected.version || header.dependencyBytes > rest.size() ||
        header.blobBytes != rest.size() - header.dependencyBytes) {
        return std::nullopt;
    }
    const auto list = rest.first(header.dependencyBytes);
    if (hashOfBytes(list) != header.dependencyHash) return std::nullopt;
    const auto dependencies = unpackedDependencies(
        {reinterpret_cast<const char*>(list.data()), list.size()}, header.dependencies);
    if (!dependencies) return std::nullopt;
    const SceneFolder folder(key.scene.parent_path(), key.limits.fileBytes, key.limits.maxFiles);
    for (const FileDependency& known : *dependencies) {
        const bool unchanged = known.name == key.content.name
                                   ? known == key.content
                                   : currentState(folder, known) == known;
        if (!unchanged) return std::nullopt;
    }
    Scene scene = readScene(rest.subspan(header.dependencyBytes));
    if (!sceneProblems(scene).empty()) return std::nullopt;
    return scene;
}

}  // namespace

std::optional<CacheContent> readCacheFile(const fs::path& file, std::uint64_t maxBytes) {
    const CacheDescriptor in(open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
    struct stat about {};
    if (in.value < 0 || fstat(in.value, &about) != 0 || !S_ISREG(about.st_mode) ||
        about.st_uid != geteuid() || static_cast<std::uint64_t>(about.st_size) > maxBytes) {
        return std::nullopt;
    }
    CacheContent content{
        std::make_unique_for_overwrite<std::byte[]>(static_cast<std::size_t>(about.st_size)),
        static_cast<std::size_t>(about.st_size)};
    for (std::size_t at = 0; at < content.size;) {
        const ssize_t n = read(in.value, content.bytes.get() + at, content.size - at);
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) return std::nullopt;
        at += static_cast<std::size_t>(n);
    }
    futimens(in.value, nullptr);  // last use: now
    return content;
}

// The file has a temporary name until it is complete. It is not flushed to the disk: after a power
// failure its length or checksum is wrong.
bool writeCacheFile(const fs::path& file, std::initializer_list<std::span<const std::byte>> parts) {
    const fs::path folder = file.parent_path();
    std::error_code ignored;
    fs::create_directories(folder.parent_path(), ignored);
    if (mkdir(folder.c_str(), 0700) != 0 && errno != EEXIST) return false;
    fs::path temporary = file;
    temporary += "." + std::to_string(getpid()) + kTemporary;
    {
        const CacheDescriptor out(
            open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, 0600));
        if (out.value < 0) return false;
        const bool complete = std::all_of(parts.begin(), parts.end(), [&](const auto& part) {
            return writeAll(out.value, part);
        });
        if (complete && rename(temporary.c_str(), file.c_str()) == 0) return true;
    }
    const int error = errno;
    unlink(temporary.c_str());
    errno = error;
    return false;
}

void trimCacheFolder(const fs::path& folder, const char* extension, std::uint64_t maxBytes) {
    struct Candidate {
        fs::file_time_type used;
        std::uint64_t bytes;
        fs::path file;
    };
    std::vector<Candidate> list;
    std::uint64_t sum = 0;
    std::error_code error;
    const auto abandoned = fs::file_time_type::clock::now() - std::chrono::hours(1);
    for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
        std::error_code failure;
        const Candidate candidate{it->last_write_time(failure), it->file_size(failure), it->path()};
        if (failure) continue;
        const std::string itsExtension = candidate.file.extension().string();
        if (itsExtension == kTemporary && candidate.used < abandoned)
            fs::remove(candidate.file, failure);
        if (itsExtension != extension) continue;
        sum += candidate.bytes;
        list.push_back(candidate);
    }
    std::sort(list.begin(), list.end(),
              [](const Candidate& a, const Candidate& b) { return a.used < b.used; });
    for (const Candidate& candidate : list) {
        if (sum <= maxBytes) return;
        std::error_code failure;
        fs::remove(candidate.file, failure);
        sum -= candidate.bytes;
    }
}

std::optional<SceneCache::Key> SceneCache::keyOf(const fs::path& scene,
                                                 const ImportLimits& limits) const {
    try {
        const SceneFolder folder(scene.parent_path(), limits.fileBytes, limits.maxFiles);
        Key key{.scene = scene, .limits = limits};
        key.content.name = scene.filename().string();
        const std::string content = folder.read(key.content.name);
        setContent(key.content, content);
        key.hash = sha256(
            options_.version + '\n' + key.content.name + '\n' + encoded(limits) + '\n', content);
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
        const auto content = readCacheFile(fileOf(key), options_.maxBytes);
        return content ? validScene(content->span(), key) : std::nullopt;
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
