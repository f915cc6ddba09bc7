#include "scene/import/sandbox/process.h"

#include "scene/import/base/clean_text.h"
#include "scene/import/base/imported_scene.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <sstream>
#include <thread>
#include <utility>

extern char** environ;

namespace clerestory {
namespace {

using Reason = ImportError::Reason;
using Clock = std::chrono::steady_clock;

constexpr int kResultInChild = 3;
constexpr int kProgressInChild = 4;

class Descriptor {
public:
    explicit Descriptor(int value = -1) : value_(value) {}
    Descriptor(Descriptor&& other) noexcept : value_(std::exchange(other.value_, -1)) {}
    Descriptor& operator=(Descriptor&&) = delete;
    ~Descriptor() { reset(); }
    int value() const { return value_; }
    void reset() {
        if (value_ >= 0) close(std::exchange(value_, -1));
    }

private:
    int value_;
};

[[noreturn]] void failed(const char* what) {
    throw std::runtime_error(std::string("import process: ") + what + " failed");
}

// A duplicate above the descriptors that the child sees, so that dup2() overwrites none in use.
Descriptor duplicatedHigh(int descriptor) {
    const Descriptor original(descriptor);
    Descriptor high(descriptor < 0 ? -1 : fcntl(descriptor, F_DUPFD_CLOEXEC, 16));
    if (high.value() < 0) failed("duplicating a descriptor");
    return high;
}

class Child {
public:
    Child(const std::filesystem::path& program, const std::filesystem::path& file, const char* kind,
          const std::string& scene, const ImportLimits& limits, const Descriptor& result,
          const Descriptor& progress) {
        posix_spawn_file_actions_t actions;
        posix_spawn_file_actions_init(&actions);
        posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
        posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
        posix_spawn_file_actions_adddup2(&actions, result.value(), kResultInChild);
        posix_spawn_file_actions_adddup2(&actions, progress.value(), kProgressInChild);
        posix_spawn_file_actions_addclosefrom_np(&actions, kProgressInChild + 1);
        posix_spawnattr_t attributes;
        posix_spawnattr_init(&attributes);
        sigset_t none;
        sigemptyset(&none);
        posix_spawnattr_setsigmask(&attributes, &none);
        posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
        std::array<std::string, 13> words{program.string(),
                                          "import-child",
                                          file.string(),
                                          "--result-fd",
                                          std::to_string(kResultInChild),
                                          "--progress-fd",
                                          std::to_string(kProgressInChild),
                                          "--limits",
                                          encoded(limits),
                                          "--as",
                                          kind,
                                          "--scene",
                                          scene};
        std::array<char*, 14> arguments{};
        for (std::size_t i = 0; i < words.size(); ++i) arguments[i] = words[i].data();
        const int status =
            posix_spawn(&id_, program.c_str(), &actions, &attributes, arguments.data(), environ);
        posix_spawn_file_actions_destroy(&actions);
        posix_spawnattr_destroy(&attributes);
        if (status != 0) failed("starting it");
    }
    ~Child() {
        if (!ended_) {
            kill();
            wait();
        }
    }
    Child(const Child&) = delete;
    Child& operator=(const Child&) = delete;

    void kill() { ::kill(id_, SIGKILL); }
    // Returns the status for the macros of waitpid().
    int wait() {
        int status = 0;
        while (waitpid(id_, &status, 0) < 0) {
            if (errno != EINTR) failed("waiting for it");
        }
        ended_ = true;
        return status;
    }
    std::optional<int> waitUntil(Clock::time_point deadline) {
        for (;;) {
            int status = 0;
            const pid_t got = waitpid(id_, &status, WNOHANG);
            if (got == id_) {
                ended_ = true;
                return status;
            }
            if (got < 0 && errno != EINTR) failed("waiting for it");
            if (Clock::now() >= deadline) return std::nullopt;
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
    }

private:
    pid_t id_ = -1;
    bool ended_ = false;
};

// Reads the child's lines until it closes its end of the pipe. Returns false at the deadline.
class ProgressReader {
public:
    ProgressReader(const Descriptor& pipe, const ProgressCallback& progress)
        : pipe_(pipe), progress_(progress) {}

    bool readUntil(Clock::time_point deadline) {
        for (;;) {
            const auto left =
                std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now());
            if (left.count() <= 0) return false;
            pollfd event{pipe_.value(), POLLIN, 0};
            const int ready = poll(
                &event, 1, static_cast<int>(std::min<std::int64_t>(left.count() + 1, 1'000'000)));
            if (ready < 0 && errno != EINTR) failed("reading from it");
            if (ready <= 0) continue;
            char bytes[4096];
            const ssize_t got = read(pipe_.value(), bytes, sizeof bytes);
            if (got == 0) return true;
            for (ssize_t i = 0; i < got; ++i) receive(bytes[i]);
        }
    }

    const std::optional<ImportError>& error() const { return error_; }
    std::vector<FileDependency> takeDependencies() { return std::move(dependencies_); }

private:
    void receive(char c) {
        constexpr std::size_t kMaxLine = 8192, kMaxDependencies = 10'000;
        if (c != '\n') {
            if (line_.size() < kMaxLine) line_ += c;
            return;
        }
        if (const auto step = readProgress(line_); step && progress_) progress_(*step);
        if (const auto error = readError(line_)) error_.emplace(*error);
        if (auto dependency = readDependency(line_);
            dependency && dependencies_.size() < kMaxDependencies) {
            dependencies_.push_back(*std::move(dependency));
        }
        line_.clear();
    }

    const Descriptor& pipe_;
    const ProgressCallback& progress_;
    std::string line_;
    std::optional<ImportError> error_;
    std::vector<FileDependency> dependencies_;
};

[[noreturn]] void throwFailure(int status, const std::optional<ImportError>& error) {
    if (WIFEXITED(status) && WEXITSTATUS(status) == kChildRefused && error) {
        throw ImportError(*error);
    }
    if (WIFSIGNALED(status) && (WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL)) {
        // The kernel sends either signal at the CPU limit; SIGKILL also when memory is exhausted.
        throw ImportError(Reason::timedOut,
                          "the import used too much processor time and was stopped");
    }
    throw ImportError(Reason::crashed, "the import crashed; the file is probably malformed");
}

class Mapping {
public:
    explicit Mapping(const Descriptor& file)
        : size_(sizeOf(file)),
          bytes_(mmap(nullptr, size_, PROT_READ, MAP_PRIVATE | MAP_POPULATE, file.value(), 0)) {
        if (bytes_ == MAP_FAILED)
            throw ImportError(Reason::memory, "not enough memory for the result");
    }
    ~Mapping() { munmap(bytes_, size_); }
    Mapping(const Mapping&) = delete;
    Mapping& operator=(const Mapping&) = delete;
    std::span<const std::byte> bytes() const { return {static_cast<std::byte*>(bytes_), size_}; }

private:
    static std::size_t sizeOf(const Descriptor& file) {
        struct stat about {};
        if (fstat(file.value(), &about) != 0) failed("inspecting the result");
        return static_cast<std::size_t>(about.st_size);
    }

    std::size_t size_;
    void* bytes_;
};

}  // namespace

std::string progressLine(const ImportProgress& progress) {
    const int permille = static_cast<int>(std::clamp(progress.progress, 0.0, 1.0) * 1000.0);
    return "progress " + std::to_string(permille) + " " + progress.stage + "\n";
}

std::string errorLine(ImportError::Reason reason, const std::string& message) {
    return "error " + std::string(nameOf(reason)) + " " + cleanText(message) + "\n";
}

std::optional<ImportProgress> readProgress(const std::string& line) {
    int permille = 0;
    constexpr std::string_view kStart = "progress ";
    const char* end = line.data() + line.size();
    if (!line.starts_with(kStart)) {
        return std::nullopt;
    }
    const auto read = std::from_chars(line.data() + kStart.size(), end, permille);
    if (read.ec != std::errc() || read.ptr == end || permille < 0 || permille > 1000) {
        return std::nullopt;
    }
    return ImportProgress{cleanText(std::string(read.ptr + 1, end)), permille / 1000.0};
}

// The name is last on the line. A newline in it is written as a zero byte, which no file name has.
std::string dependencyLine(const FileDependency& dependency) {
    std::ostringstream text;
    text << "file " << static_cast<int>(dependency.state) << ' ' << dependency.low << ' '
         << dependency.high << ' ';
    for (const char c : dependency.name) text << (c == '\n' ? '\0' : c);
    text << '\n';
    return text.str();
}

std::optional<FileDependency> readDependency(const std::string& line) {
    std::istringstream in(line);
    std::string word;
    int state = -1;
    FileDependency dependency;
    in >> word >> state >> dependency.low >> dependency.high;
    if (!in || word != "file" || state < 0 || state > 3 || in.get() != ' ') return std::nullopt;
    dependency.state = static_cast<FileDependency::State>(state);
    std::getline(in, dependency.name);
    std::replace(dependency.name.begin(), dependency.name.end(), '\0', '\n');
    return dependency;
}

std::optional<ImportError> readError(const std::string& line) {
    using Reason = ImportError::Reason;
    for (const Reason reason : {Reason::notFound, Reason::unsupported, Reason::malformed,
                                Reason::crashed, Reason::timedOut, Reason::memory, Reason::limit}) {
        const std::string start = "error " + std::string(nameOf(reason)) + " ";
        if (line.starts_with(start)) {
            return ImportError(reason, cleanText(line.substr(start.size())));
        }
    }
    return std::nullopt;
}

ChildResult runImportChild(const std::filesystem::path& file, const char* kind,
                           const std::string& scene, const std::filesystem::path& program,
                           const ImportLimits& limits, const ProgressCallback& progress) {
    const Clock::time_point deadline = Clock::now() + limits.wallClock;
    Descriptor result = duplicatedHigh(memfd_create(kind, MFD_CLOEXEC | MFD_ALLOW_SEALING));
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0) failed("creating a pipe");
    const Descriptor readEnd(ends[0]);
    Descriptor writeEnd = duplicatedHigh(ends[1]);

    Child child(program.empty() ? "/proc/self/exe" : program, file, kind, scene, limits, result,
                writeEnd);
    writeEnd.reset();  // so that only the child has the write end
    ProgressReader reader(readEnd, progress);
    const bool closed = reader.readUntil(deadline);
    const std::optional<int> status = closed ? child.waitUntil(deadline) : std::nullopt;
    if (!status) {
        throw ImportError(Reason::timedOut, "the import took too long and was stopped");
    }
    if (!WIFEXITED(*status) || WEXITSTATUS(*status) != 0) {
        throwFailure(*status, reader.error());
    }
    // Sealed, so that the bytes cannot change between the check and the use.
    struct stat about {};
    if (fcntl(result.value(), F_ADD_SEALS, F_SEAL_WRITE | F_SEAL_SHRINK | F_SEAL_GROW) != 0 ||
        fstat(result.value(), &about) != 0 || about.st_size <= 0) {
        throw ImportError(Reason::crashed, "the import returned no result");
    }
    const auto mapping = std::make_shared<const Mapping>(result);
    return {mapping, mapping->bytes(), reader.takeDependencies()};
}

}  // namespace clerestory
