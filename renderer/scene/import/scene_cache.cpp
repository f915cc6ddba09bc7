// A file: header, readings, blob. The header says how long the others are and has the readings'
// checksum; the blob has its own.
#include "scene/import/scene_cache.h"

#include "scene/import/import_wire.h"
#include "scene/import/kept_file.h"
#include "scene/import/scene_blob.h"
#include "scene/import/scene_folder.h"

#include <openssl/evp.h>
#define XXH_INLINE_ALL
#include <xxhash.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace clerestory {
namespace {

namespace fs = std::filesystem;

constexpr const char* kExtension = ".scene";
constexpr std::size_t kMaxReadings = 8192, kMaxWaiting = 2;

struct EntryHeader {
    char magic[8] = {'C', 'L', 'C', 'A', 'C', 'H', 'E', '\0'};
    std::uint32_t version = 1;
    std::uint32_t readings = 0;
    std::uint64_t readingsBytes = 0, readingsHash = 0, blobBytes = 0;
};

std::string sha256(std::string_view content, std::string_view more) {
    unsigned char digest[EVP_MAX_MD_SIZE];
    unsigned size = 0;
    const std::unique_ptr<EVP_MD_CTX, void (*)(EVP_MD_CTX*)> hash(EVP_MD_CTX_new(),
                                                                  EVP_MD_CTX_free);
    const bool made = hash && EVP_DigestInit_ex(hash.get(), EVP_sha256(), nullptr) == 1 &&
                      EVP_DigestUpdate(hash.get(), more.data(), more.size()) == 1 &&
                      EVP_DigestUpdate(hash.get(), content.data(), content.size()) == 1 &&
                      EVP_DigestFinal_ex(hash.get(), digest, &size) == 1;
    if (!made) throw std::bad_alloc();
    std::string hex;
    for (unsigned i = 0; i < size; ++i) {
        hex += "0123456789abcdef"[digest[i] >> 4];
        hex += "0123456789abcdef"[digest[i] & 15];
    }
    return hex;
}

// What the folder answers to the same question now.
FileReading askedAgain(const SceneFolder& folder, const FileReading& question) {
    FileReading now{.name = question.name};
    if (question.outcome == FileReading::Outcome::present) {
        if (folder.has(question.name)) now.outcome = FileReading::Outcome::present;
        return now;
    }
    return folder.reading(question.name);
}

std::string packed(const std::vector<FileReading>& readings) {
    std::string text;
    const auto add = [&](const auto& value) {
        text.append(reinterpret_cast<const char*>(&value), sizeof value);
    };
    for (const FileReading& r : readings) {
        add(r.outcome);
        add(r.low);
        add(r.high);
        add(static_cast<std::uint32_t>(r.name.size()));
        text += r.name;
    }
    return text;
}

// Nothing for what packed() did not write.
std::optional<std::vector<FileReading>> unpackedReadings(std::string_view text,
                                                         std::uint32_t count) {
    std::vector<FileReading> list;
    bool sound = count <= kMaxReadings;
    const auto take = [&](auto& value) {
        sound = sound && text.size() >= sizeof value;
        if (!sound) return;
        std::memcpy(&value, text.data(), sizeof value);
        text.remove_prefix(sizeof value);
    };
    for (std::uint32_t i = 0; sound && i < count; ++i) {
        FileReading& r = list.emplace_back();
        std::uint32_t size = 0;
        take(r.outcome);
        take(r.low);
        take(r.high);
        take(size);
        sound = sound && size <= text.size() && r.outcome <= FileReading::Outcome::read;
        if (!sound) break;
        r.name = text.substr(0, size);
        text.remove_prefix(size);
    }
    if (!sound || !text.empty()) return std::nullopt;
    return list;
}

// The scene of a file's bytes, when everything about them is right.
std::optional<Scene> sceneIn(std::span<const std::byte> bytes, const SceneCache::Place& place) {
    EntryHeader header;
    const EntryHeader expected;
    if (bytes.size() < sizeof header) return std::nullopt;
    std::memcpy(&header, bytes.data(), sizeof header);
    const auto rest = bytes.subspan(sizeof header);
    if (std::memcmp(header.magic, expected.magic, sizeof header.magic) != 0 ||
        header.version != expected.version || header.readingsBytes > rest.size() ||
        header.blobBytes != rest.size() - header.readingsBytes) {
        return std::nullopt;
    }
    const auto list = rest.first(header.readingsBytes);
    if (XXH3_64bits(list.data(), list.size()) != header.readingsHash) return std::nullopt;
    const auto readings = unpackedReadings(
        {reinterpret_cast<const char*>(list.data()), list.size()}, header.readings);
    if (!readings) return std::nullopt;
    const SceneFolder folder(place.scene.parent_path(), place.limits.fileBytes,
                             place.limits.maxFiles);
    for (const FileReading& then : *readings) {
        const bool same =
            then.name == place.whole.name ? then == place.whole : askedAgain(folder, then) == then;
        if (!same) return std::nullopt;
    }
    Scene scene = readScene(rest.subspan(header.readingsBytes));
    if (!sceneProblems(scene).empty()) return std::nullopt;
    return scene;
}

}  // namespace

std::optional<SceneCache::Place> SceneCache::placeOf(const fs::path& scene,
                                                     const ImportLimits& limits) const {
    try {
        const SceneFolder folder(scene.parent_path(), limits.fileBytes, limits.maxFiles);
        Place place{.scene = scene, .limits = limits};
        place.whole.name = scene.filename().string();
        const std::string content = folder.read(place.whole.name);
        setHash(place.whole, content);
        place.key = sha256(
            content, options_.version + '\n' + place.whole.name + '\n' + encoded(limits) + '\n');
        return place;
    } catch (const ImportError&) {
        return std::nullopt;
    }
}

fs::path SceneCache::fileOf(const Place& place) const {
    return options_.folder / (place.key + kExtension);
}

std::optional<Scene> SceneCache::find(const Place& place) {
    try {
        const auto content = readKept(fileOf(place), options_.mostBytes);
        return content ? sceneIn(content->span(), place) : std::nullopt;
    } catch (const BlobError&) {
    } catch (const ImportError&) {
    } catch (const std::bad_alloc&) {
    }
    return std::nullopt;
}

void SceneCache::keep(const Place& place, const std::vector<FileReading>& readings,
                      std::span<const std::byte> blob, std::shared_ptr<const void> owner) {
    // The scene file may have changed between our look at it and the import's.
    const bool same = std::find(readings.begin(), readings.end(), place.whole) != readings.end();
    if (!same || readings.size() > kMaxReadings || blob.size() > options_.mostBytes / 2) return;
    const std::string list = packed(readings);
    EntryHeader header;
    header.readings = static_cast<std::uint32_t>(readings.size());
    header.readingsBytes = list.size();
    header.readingsHash = XXH3_64bits(list.data(), list.size());
    header.blobBytes = blob.size();
    std::string head(reinterpret_cast<const char*>(&header), sizeof header);
    const std::lock_guard lock(mutex_);
    if (toWrite_.size() >= kMaxWaiting) return;  // they hold memory
    toWrite_.push_back({fileOf(place), head + list, blob, std::move(owner)});
    if (!writer_.joinable()) writer_ = std::thread([this] { write(); });
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

void SceneCache::finish() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return toWrite_.empty() && !writing_; });
}

// The writer's thread.
void SceneCache::write() {
    std::unique_lock lock(mutex_);
    for (;;) {
        changed_.wait(lock, [&] { return ending_ || !toWrite_.empty(); });
        if (toWrite_.empty()) return;
        {
            const Kept kept = std::move(toWrite_.front());
            toWrite_.pop_front();
            writing_ = true;
            lock.unlock();
            write(kept);
        }
        lock.lock();
        writing_ = false;
        changed_.notify_all();
    }
}

void SceneCache::write(const Kept& kept) {
    if (wrote(kept)) {
        complained_ = false;
        return sweepKept(options_.folder, kExtension, options_.mostBytes);
    }
    if (std::exchange(complained_, true) || !options_.complain) return;
    options_.complain("imported scenes cannot be kept in \"" + options_.folder.string() +
                      "\": " + std::strerror(errno));
}

bool SceneCache::wrote(const Kept& kept) const {
    return writeKept(kept.file, {std::as_bytes(std::span(kept.head)), kept.blob});
}

}  // namespace clerestory
