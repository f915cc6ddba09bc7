// The kernel keeps the fence (openat2) where it can; older kernels get a comparison of real paths.
#include "scene/import/scene_folder.h"

#include <fcntl.h>
#include <linux/openat2.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>

namespace clerestory {
namespace {

using Reason = ImportError::Reason;

constexpr int kReadFlags = O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY;  // a pipe must not block

// Where the descriptor's file really is; empty when that cannot be told.
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

class FolderDescriptor {
public:
    explicit FolderDescriptor(int value) : value_(value) {}
    ~FolderDescriptor() {
        if (value_ >= 0) {
            close(value_);
        }
    }
    FolderDescriptor(const FolderDescriptor&) = delete;
    FolderDescriptor& operator=(const FolderDescriptor&) = delete;
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

// "textures/../a.png" is as good as "a.png", and nothing leads out: there is no outside.
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
    const bool there = FolderDescriptor(open(name)).value() >= 0;
    note({name, there ? FileReading::Outcome::present : FileReading::Outcome::absent});
    return there;
}

std::string SceneFolder::read(const std::string& name) const {
    if (folder_ < 0) {
        if (const std::string* content = inMemory(name)) return *content;
        throw ImportError(Reason::notFound, "'" + name + "' is not in the archive");
    }
    const FolderDescriptor file(open(name));
    if (file.value() < 0) {
        note({name, FileReading::Outcome::absent});
        throw ImportError(Reason::notFound,
                          "'" + name + "' is not a readable file in the scene's folder");
    }
    note({name, FileReading::Outcome::refused});  // unless what follows succeeds
    std::string content = readFrom(file.value(), name);
    FileReading reading{name};
    setHash(reading, content);
    note(reading);
    return content;
}

FileReading SceneFolder::reading(const std::string& name) const {
    try {
        read(name);
    } catch (const ImportError&) {
    }
    const std::lock_guard lock(mutex_);
    return readings_.at(name);
}

// What was read counts, then what was refused, then whether it is there.
void SceneFolder::note(const FileReading& reading) const {
    const std::lock_guard lock(mutex_);
    FileReading& known = readings_.try_emplace(reading.name, reading).first->second;
    if (reading.outcome > known.outcome) known = reading;
}

std::vector<FileReading> SceneFolder::readings() const {
    const std::lock_guard lock(mutex_);
    std::vector<FileReading> list;
    for (const auto& [name, reading] : readings_) list.push_back(reading);
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
        const ssize_t got = ::read(file, content.data() + filled, content.size() - filled);
        if (got < 0 && errno == EINTR) {
            continue;
        }
        if (got <= 0) {
            break;
        }
        filled += static_cast<std::size_t>(got);
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
