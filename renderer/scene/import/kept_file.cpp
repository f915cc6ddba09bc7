#include "scene/import/kept_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <string>
#include <vector>

namespace clerestory {
namespace {

namespace fs = std::filesystem;

constexpr const char* kUnfinished = ".unfinished";

struct KeptDescriptor {
    explicit KeptDescriptor(int number) : value(number) {}
    ~KeptDescriptor() {
        if (value >= 0) close(value);
    }
    KeptDescriptor(const KeptDescriptor&) = delete;
    KeptDescriptor& operator=(const KeptDescriptor&) = delete;
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

}  // namespace

std::optional<KeptContent> readKept(const fs::path& file, std::uint64_t most) {
    const KeptDescriptor in(open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
    struct stat about {};
    if (in.value < 0 || fstat(in.value, &about) != 0 || !S_ISREG(about.st_mode) ||
        about.st_uid != geteuid() || static_cast<std::uint64_t>(about.st_size) > most) {
        return std::nullopt;
    }
    KeptContent content{
        std::make_unique_for_overwrite<std::byte[]>(static_cast<std::size_t>(about.st_size)),
        static_cast<std::size_t>(about.st_size)};
    for (std::size_t at = 0; at < content.size;) {
        const ssize_t n = read(in.value, content.bytes.get() + at, content.size - at);
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) return std::nullopt;
        at += static_cast<std::size_t>(n);
    }
    futimens(in.value, nullptr);  // used now
    return content;
}

// Under another name until it is whole. Not flushed to the disk: whatever a power cut leaves of it
// has a wrong length or checksum.
bool writeKept(const fs::path& file, std::initializer_list<std::span<const std::byte>> parts) {
    const fs::path folder = file.parent_path();
    std::error_code ignored;
    fs::create_directories(folder.parent_path(), ignored);
    if (mkdir(folder.c_str(), 0700) != 0 && errno != EEXIST) return false;
    fs::path unfinished = file;
    unfinished += "." + std::to_string(getpid()) + kUnfinished;
    {
        const KeptDescriptor out(
            open(unfinished.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, 0600));
        if (out.value < 0) return false;
        const bool whole = std::all_of(parts.begin(), parts.end(),
                                       [&](const auto& part) { return writeAll(out.value, part); });
        if (whole && rename(unfinished.c_str(), file.c_str()) == 0) return true;
    }
    const int error = errno;
    unlink(unfinished.c_str());
    errno = error;
    return false;
}

void sweepKept(const fs::path& folder, const char* extension, std::uint64_t mostBytes) {
    struct There {
        fs::file_time_type used;
        std::uint64_t bytes;
        fs::path file;
    };
    std::vector<There> list;
    std::uint64_t sum = 0;
    std::error_code error;
    const auto forgotten = fs::file_time_type::clock::now() - std::chrono::hours(1);
    for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
        std::error_code gone;
        const There kept{it->last_write_time(gone), it->file_size(gone), it->path()};
        if (gone) continue;
        const std::string own = kept.file.extension().string();
        if (own == kUnfinished && kept.used < forgotten) fs::remove(kept.file, gone);
        if (own != extension) continue;
        sum += kept.bytes;
        list.push_back(kept);
    }
    std::sort(list.begin(), list.end(),
              [](const There& a, const There& b) { return a.used < b.used; });
    for (const There& kept : list) {
        if (sum <= mostBytes) return;
        std::error_code gone;
        fs::remove(kept.file, gone);
        sum -= kept.bytes;
    }
}

}  // namespace clerestory
