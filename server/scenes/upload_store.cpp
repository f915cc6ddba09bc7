// A folder ID/ contains scene.KIND or map.KIND, about.json and, while it is loaded, tries. It is
// created under a hidden name and renamed when all its files are written to disk.
#include "server/scenes/upload_store.h"

#include "server/base/problem.h"

#include <openssl/evp.h>
#include <nlohmann/json.hpp>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <fstream>

namespace clerestory {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kIdBegin = "upload-";
constexpr std::size_t kIdDigits = 32;  // of SHA-256, in hex
constexpr const char* kUnfinished = ".coming-";
constexpr const char* kTries = "tries";
constexpr const char* kSceneKinds[] = {"glb", "gltf", "zip", "tar", "tgz",
                                       "stl", "ply",  "fbx", "dae", "3ds"};
constexpr const char* kMapKinds[] = {"hdr", "exr", "ktx", "ktx2", "dds"};

std::string fileNameOf(std::string_view kind) {
    return (UploadStore::isMapKind(kind) ? "map." : "scene.") + std::string(kind);
}

// Returns false with errno if the file cannot be written to disk.
bool wrote(const fs::path& file, std::string_view content) {
    const int descriptor = open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    if (descriptor < 0) return false;
    while (!content.empty()) {
        const ssize_t n = write(descriptor, content.data(), content.size());
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) break;
        content.remove_prefix(static_cast<std::size_t>(n));
    }
    const bool whole = content.empty() && fsync(descriptor) == 0;
    const int error = errno;
    close(descriptor);
    errno = error;
    return whole;
}

void flushFolder(const fs::path& folder) {
    const int descriptor = open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (descriptor < 0) return;
    fsync(descriptor);
    close(descriptor);
}

void removeQuietly(const fs::path& place) {
    std::error_code ignored;
    fs::remove_all(place, ignored);
}

nlohmann::json aboutIn(const fs::path& place) {
    std::ifstream stream(place / "about.json", std::ios::binary);
    return nlohmann::json::parse(stream, nullptr, false);
}

std::string textIn(const nlohmann::json& object, const char* name) {
    const auto found = object.find(name);
    return found != object.end() && found->is_string() ? found->get<std::string>() : "";
}

std::string aboutText(const nlohmann::json& about) {
    return about.dump(1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace

UploadStore::UploadStore(fs::path folder, const UploadLimits& limits)
    : folder_(std::move(folder)), limits_(limits) {
    std::error_code error;
    fs::create_directories(folder_.parent_path(), error);
    if (mkdir(folder_.c_str(), 0700) != 0 && errno != EEXIST) {
        throw std::runtime_error("cannot make the folder \"" + folder_.string() +
                                 "\": " + std::strerror(errno));
    }
    if (access(folder_.c_str(), R_OK | W_OK | X_OK) != 0 || !fs::is_directory(folder_)) {
        throw std::runtime_error("cannot use the folder \"" + folder_.string() + "\" for uploads");
    }
    // Folders that a server left unfinished.
    const auto old = fs::file_time_type::clock::now() - std::chrono::hours(1);
    for (fs::directory_iterator it(folder_, error), end; !error && it != end; it.increment(error)) {
        if (!it->path().filename().string().starts_with(kUnfinished)) continue;
        std::error_code unknown;
        if (it->last_write_time(unknown) < old && !unknown) removeQuietly(it->path());
    }
}

namespace {

std::uint32_t number32(std::string_view content, std::size_t at) {  // little-endian
    std::uint32_t number = 0;
    std::memcpy(&number, content.data() + at, sizeof number);
    return number;
}

// The header has no mark, so the number of its triangles must give the size of the file. An ASCII
// header begins with "solid", which many binary ones do as well.
bool isStl(std::string_view content) {
    constexpr std::size_t kHeader = 80, kTriangle = 50;
    const bool isBinary =
        content.size() >= kHeader + 4 &&
        content.size() == kHeader + 4 + kTriangle * std::size_t{number32(content, kHeader)};
    return isBinary || (content.starts_with("solid") &&
                        content.substr(0, 1024).find("facet") != std::string_view::npos);
}

// Chunk 0x4D4D, which holds all others, with its length.
bool is3ds(std::string_view content) {
    return content.size() >= 6 && content.starts_with("MM") &&
           number32(content, 2) == content.size();
}

}  // namespace

std::string UploadStore::kindOf(std::string_view content) {
    constexpr std::size_t kTarMark = 257;
    if (content.starts_with("glTF")) return "glb";
    if (content.starts_with("#?RADIANCE") || content.starts_with("#?RGBE")) return "hdr";
    if (content.starts_with("\x76\x2F\x31\x01")) return "exr";
    if (content.starts_with("\xABKTX 11\xBB")) return "ktx";
    if (content.starts_with("\xABKTX 20\xBB")) return "ktx2";
    if (content.starts_with("DDS ")) return "dds";
    if (content.starts_with("PK\x03\x04")) return "zip";
    if (content.starts_with("\x1f\x8b")) return "tgz";
    if (content.size() > kTarMark + 5 && content.substr(kTarMark, 5) == "ustar") return "tar";
    if (content.starts_with("Kaydara FBX Binary") || content.starts_with("; FBX")) return "fbx";
    if (content.starts_with("ply\n") || content.starts_with("ply\r")) return "ply";
    if (isStl(content)) return "stl";
    if (is3ds(content)) return "3ds";
    if (content.starts_with("\xEF\xBB\xBF")) content.remove_prefix(3);  // byte order mark
    const std::size_t first = content.find_first_not_of(" \t\r\n");
    if (first == std::string_view::npos) return "";
    const bool isXml = content[first] == '<';
    if (isXml && content.substr(first, 4096).find("<COLLADA") != std::string_view::npos) {
        return "dae";
    }
    return content[first] == '{' ? "gltf" : "";
}

bool UploadStore::isMapKind(std::string_view kind) {
    return std::find(std::begin(kMapKinds), std::end(kMapKinds), kind) != std::end(kMapKinds);
}

bool UploadStore::isId(std::string_view text) {
    if (!text.starts_with(kIdBegin) || text.size() != kIdBegin.size() + kIdDigits) return false;
    const std::string_view digits = text.substr(kIdBegin.size());
    return digits.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

std::string UploadStore::idOf(std::string_view content) {
    unsigned char digest[EVP_MAX_MD_SIZE];
    unsigned size = 0;
    if (EVP_Digest(content.data(), content.size(), digest, &size, EVP_sha256(), nullptr) != 1) {
        throw std::runtime_error("SHA-256 failed");
    }
    std::string id(kIdBegin);
    for (std::size_t i = 0; i < kIdDigits / 2; ++i) {
        char hex[3];
        std::snprintf(hex, sizeof hex, "%02x", digest[i]);
        id += hex;
    }
    return id;
}

std::optional<Upload> UploadStore::read(const fs::path& place) const {
    Upload upload{.id = place.filename().string()};
    const auto hasFile = [&](const char* kind) {
        std::error_code error;
        upload.file = place / fileNameOf(kind);
        upload.bytes = fs::file_size(upload.file, error);
        upload.isMap = isMapKind(kind);
        return !error;
    };
    if (!std::any_of(std::begin(kSceneKinds), std::end(kSceneKinds), hasFile) &&
        !std::any_of(std::begin(kMapKinds), std::end(kMapKinds), hasFile)) {
        return std::nullopt;
    }
    const nlohmann::json about = aboutIn(place);
    if (about.is_object()) {
        upload.title = textIn(about, "title");
        upload.failure = textIn(about, "failure");
        upload.reason = textIn(about, "reason");
    }
    return upload;
}

std::optional<Upload> UploadStore::find(const std::string& id) const {
    return isId(id) ? read(folder_ / id) : std::nullopt;
}

std::vector<Upload> UploadStore::all() const {
    std::vector<Upload> list;
    std::error_code error;
    for (fs::directory_iterator it(folder_, error), end; !error && it != end; it.increment(error)) {
        if (!isId(it->path().filename().string())) continue;
        if (auto upload = read(it->path())) list.push_back(*std::move(upload));
    }
    std::sort(list.begin(), list.end(),
              [](const Upload& a, const Upload& b) { return a.id < b.id; });
    return list;
}

// Removes uploads that are known to fail if the limits are reached.
void UploadStore::requireRoom(std::size_t bytes) const {
    std::vector<Upload> kept = all();
    std::uint64_t sum = bytes;
    for (const Upload& upload : kept) sum += upload.bytes;
    while (kept.size() >= limits_.count || sum > limits_.keptBytes) {
        const auto useless = std::find_if(kept.begin(), kept.end(),
                                          [](const Upload& u) { return !u.failure.empty(); });
        if (useless == kept.end()) {
            throw RequestError(
                noRoom("The limit of uploads is reached: " + std::to_string(kept.size()) + " of " +
                       std::to_string(limits_.count) + ". DELETE one that is not needed."));
        }
        removeQuietly(folder_ / useless->id);
        sum -= useless->bytes;
        kept.erase(useless);
    }
}

Upload UploadStore::add(const std::string& kind, const std::string& title,
                        std::string_view content) {
    const std::string id = idOf(content);
    const std::lock_guard lock(adding_);
    if (auto there = find(id)) return *std::move(there);
    requireRoom(content.size());
    std::string pattern = (folder_ / (kUnfinished + std::string("XXXXXX"))).string();
    const bool made = mkdtemp(pattern.data()) != nullptr;
    const fs::path unfinished = pattern;
    const bool whole = made && wrote(unfinished / fileNameOf(kind), content) &&
                       wrote(unfinished / "about.json", aboutText({{"title", title}}));
    if (!whole || rename(unfinished.c_str(), (folder_ / id).c_str()) != 0) {
        const int error = errno;
        if (made) removeQuietly(unfinished);
        if (auto there = find(id)) return *std::move(there);  // stored by another process
        if (error == ENOSPC || error == EDQUOT || error == EFBIG) {
            throw RequestError(noRoom("The disk for uploads is full."));
        }
        throw std::runtime_error("an upload could not be stored: " +
                                 std::string(std::strerror(error)));
    }
    flushFolder(folder_);
    return {.id = id,
            .title = title,
            .file = folder_ / id / fileNameOf(kind),
            .bytes = content.size(),
            .isMap = isMapKind(kind)};
}

bool UploadStore::remove(const std::string& id) {
    if (!find(id)) return false;
    // Atomic for other processes: renamed before its files are removed.
    const fs::path place = folder_ / id;
    std::string pattern = (folder_ / (kUnfinished + std::string("XXXXXX"))).string();
    if (mkdtemp(pattern.data()) && rename(place.c_str(), pattern.c_str()) == 0) {
        removeQuietly(pattern);
    } else {
        removeQuietly(place);
    }
    return true;
}

// Replaces about.json atomically.
void UploadStore::setFailure(const std::string& id, const std::string& message,
                             const std::string& reason) {
    const auto upload = find(id);
    if (!upload || upload->failure == message) return;
    const fs::path place = folder_ / id, next = place / "about.next";
    nlohmann::json about = {{"title", upload->title}};
    if (!message.empty()) about.update({{"failure", message}, {"reason", reason}});
    std::error_code ignored;
    fs::remove(next, ignored);
    if (wrote(next, aboutText(about))) fs::rename(next, place / "about.json", ignored);
}

// A file with one byte for each attempt. It must survive the end of the process, not of the
// machine, so it is not flushed.
std::uint64_t UploadStore::beginLoading(const std::string& id) {
    if (!find(id)) return 0;
    const fs::path tries = folder_ / id / kTries;
    std::error_code none;
    const std::uint64_t before = fs::file_size(tries, none);
    std::ofstream(tries, std::ios::binary | std::ios::app) << '.';
    return none ? 0 : before;
}

void UploadStore::endLoading(const std::string& id) {
    std::error_code ignored;
    if (isId(id)) fs::remove(folder_ / id / kTries, ignored);
}

}  // namespace clerestory
