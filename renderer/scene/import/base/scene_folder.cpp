// The kernel confines lookups to the folder (openat2); on kernels without it, real paths are
// compared.
#include "scene/import/base/scene_folder.h"

#include "scene/hash.h"

#include <fcntl.h>
#include <linux/openat2.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <span>

namespace clerestory {
namespace {

using Reason = ImportError::Reason;

constexpr int kReadFlags = O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY;  // a pipe must not block

// The resolved path of the descriptor's file; empty if it cannot be determined.
std::string realPath(int descriptor) {
    char path[PATH_MAX];
    const std::string link = "/proc/self/fd/" + std::to_string(descriptor);
    const ssize_t length = readlink(link.c_str(), path, sizeof path);
    return length > 0 && length < PATH_MAX ? std::string(path, static_cast<std::size_t>(length))
                                           : std::string();
}

int openBelow(int folder, const std::string& name) {
    open_how how{};
    how.flags = kReadFlags;
    how.resolve = RESOLVE_BENEATH | RESOLVE_NO_SYMLINKS | RESOLVE_NO_MAGICLINKS;
    const long opened = syscall(SYS_openat2, folder, name.c_str(), &how, sizeof how);
    if (opened >= 0 || errno != ENOSYS) {
        return static_cast<int>(opened);
    }
    const int descriptor = openat(folder, name.c_str(), kReadFlags | O_NOFOLLOW);
    const std::string root = realPath(folder);
    if (descriptor >= 0 && (root.empty() || !realPath(descriptor).starts_with(root + "/"))) {
        close(descriptor);
        return -1;
    }
    return descriptor;
}

class FileDescriptor {
public:
    explicit FileDescriptor(int value) : value_(value) {}
    ~FileDescriptor() {
        if (value_ >= 0) {
            close(value_);
        }
    }
    FileDescriptor(const FileDescriptor&) = delete;
    FileDescriptor& operator=(const FileDescriptor&) = delete;
    int value() const { return value_; }

private:
    int value_;
};

int hexDigit(char c) {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return -1;
}

}  // namespace

void setContent(FileDependency& dependency, std::string_view content) {
    const Hash128 hash = hash128OfBytes(std::as_bytes(std::span(content)));
    dependency.state = FileDependency::State::read;
    dependency.low = hash.low;
    dependency.high = hash.high;
}

SceneFolder::SceneFolder(std::map<std::string, std::string> files) : files_(std::move(files)) {}

SceneFolder::SceneFolder(const std::filesystem::path& folder, std::uint64_t maxBytes,
                         std::uint64_t maxFiles)
    : maxBytes_(maxBytes), maxFiles_(maxFiles) {
    const std::filesystem::path path = folder.empty() ? "." : folder;
    folder_ = ::open(path.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC);
    if (folder_ < 0) {
        throw ImportError(Reason::notFound, "the scene's folder cannot be opened");
    }
}

SceneFolder::~SceneFolder() {
    if (folder_ >= 0) close(folder_);
}

// "textures/../a.png" is equivalent to "a.png". A path that leaves the archive matches no file.
const std::string* SceneFolder::inMemory(const std::string& name) const {
    std::string relative = name;
    std::replace(relative.begin(), relative.end(), '\\', '/');
    const auto found =
        files_.find(std::filesystem::path(relative).lexically_normal().generic_string());
    return found == files_.end() ? nullptr : &found->second;
}

int SceneFolder::open(const std::string& name) const {
    if (name.empty() || name.find('\0') != std::string::npos) {
        return -1;
    }
    std::string relative = name;
    std::replace(relative.begin(), relative.end(), '\\', '/');
    const int descriptor = openBelow(folder_, relative);
    struct stat status {};
    if (descriptor >= 0 && (fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode))) {
        close(descriptor);
        return -1;
    }
    return descriptor;
}

bool SceneFolder::has(const std::string& name) const {
    if (folder_ < 0) return inMemory(name) != nullptr;
    const bool exists = FileDescriptor(open(name)).value() >= 0;
    record({name, exists ? FileDependency::State::present : FileDependency::State::absent});
    return exists;
}

std::string SceneFolder::read(const std::string& name) const {
    if (folder_ < 0) {
        if (const std::string* content = inMemory(name)) return *content;
        throw ImportError(Reason::notFound, "'" + name + "' is not in the archive");
    }
    const FileDescriptor file(open(name));
    if (file.value() < 0) {
        record({name, FileDependency::State::absent});
        throw ImportError(Reason::notFound,
                          "'" + name + "' is not a readable file in the scene's folder");
    }
    record({name, FileDependency::State::overLimit});  // replaced below if the read succeeds
    std::string content = readFrom(file.value(), name);
    FileDependency dependency{name};
    setContent(dependency, content);
    record(dependency);
    return content;
}

FileDependency SceneFolder::dependency(const std::string& name) const {
    try {
        read(name);
    } catch (const ImportError&) {
    }
    const std::lock_guard lock(mutex_);
    return dependencies_.at(name);
}

// Of several results for one file the one with the highest state is recorded.
void SceneFolder::record(const FileDependency& dependency) const {
    const std::lock_guard lock(mutex_);
    FileDependency& known = dependencies_.try_emplace(dependency.name, dependency).first->second;
    if (dependency.state > known.state) known = dependency;
}

std::vector<FileDependency> SceneFolder::dependencies() const {
    const std::lock_guard lock(mutex_);
    std::vector<FileDependency> list;
    for (const auto& [name, dependency] : dependencies_) list.push_back(dependency);
    return list;
}

std::string SceneFolder::readFrom(int file, const std::string& name) const {
    struct stat status {};
    if (fstat(file, &status) != 0) {
        throw ImportError(Reason::notFound, "'" + name + "' cannot be read");
    }
    const auto size = static_cast<std::uint64_t>(status.st_size);
    if (size > maxBytes_ || bytesRead_.fetch_add(size) + size > 4 * maxBytes_) {
        throw ImportError(Reason::limit, "'" + name + "' is larger than the limit for scene files");
    }
    if (++filesRead_ > maxFiles_) {
        throw ImportError(Reason::limit, "the scene refers to too many files");
    }
    std::string content(size, '\0');
    std::size_t filled = 0;
    while (filled < content.size()) {
        const ssize_t count = ::read(file, content.data() + filled, content.size() - filled);
        if (count < 0 && errno == EINTR) {
            continue;
        }
        if (count <= 0) {
            break;
        }
        filled += static_cast<std::size_t>(count);
    }
    content.resize(filled);
    return content;
}

std::string percentDecoded(const std::string& uri) {
    std::string text;
    for (std::size_t i = 0; i < uri.size(); ++i) {
        const int high = uri[i] == '%' && i + 2 < uri.size() ? hexDigit(uri[i + 1]) : -1;
        const int low = high >= 0 ? hexDigit(uri[i + 2]) : -1;
        if (low >= 0) {
            text += static_cast<char>(high * 16 + low);
            i += 2;
        } else {
            text += uri[i];
        }
    }
    return text;
}

}  // namespace clerestory
