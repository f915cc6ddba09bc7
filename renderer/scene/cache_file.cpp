#include "scene/cache_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
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

}  // namespace

CacheReader::CacheReader(CacheReader&& from) noexcept
    : file_(std::exchange(from.file_, -1)), left_(from.left_) {}

CacheReader::~CacheReader() {
    if (file_ >= 0) close(file_);
}

std::optional<CacheReader> CacheReader::open(const fs::path& file, std::uint64_t maxBytes) {
    CacheReader in(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK), 0);
    struct stat about {};
    if (in.file_ < 0 || fstat(in.file_, &about) != 0 || !S_ISREG(about.st_mode) ||
        about.st_uid != geteuid() || static_cast<std::uint64_t>(about.st_size) > maxBytes) {
        return std::nullopt;
    }
    in.left_ = static_cast<std::uint64_t>(about.st_size);
    futimens(in.file_, nullptr);  // last use: now
    return in;
}

bool CacheReader::read(void* to, std::size_t count) {
    if (count > left_) return false;
    for (std::size_t at = 0; at < count;) {
        const ssize_t n = ::read(file_, static_cast<std::byte*>(to) + at, count - at);
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) return false;
        at += static_cast<std::size_t>(n);
    }
    left_ -= count;
    return true;
}

std::optional<CacheContent> readCacheFile(const fs::path& file, std::uint64_t maxBytes) {
    auto in = CacheReader::open(file, maxBytes);
    if (!in) return std::nullopt;
    const auto size = static_cast<std::size_t>(in->left());
    CacheContent content{std::make_unique_for_overwrite<std::byte[]>(size), size};
    if (!in->read(content.bytes.get(), size)) return std::nullopt;
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

}  // namespace clerestory
