#include "tests/bench/cold_start.h"

#include "statistics.h"
#include "tests/support/free_port.h"

#include <httplib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <system_error>
#include <thread>

namespace clerestory::bench {
namespace {

namespace fs = std::filesystem;

constexpr double kLimitMs = 300000;                       // for a first frame, and for readiness
constexpr auto kBetween = std::chrono::milliseconds(20);  // an answer that is not 200, and the next
constexpr int kFrames = 10;

// Mesa's index file of a cache in few files: a header, then records of one size.
constexpr std::size_t kIndexHeader = 20, kIndexRecord = 28;

// A server in these folders, stopped at the end of its scope.
class RunningServer {
public:
    RunningServer(const std::string& program, const std::vector<std::string>& flags,
                  const Subject& subject, const CacheFolders& folders)
        : port_(test::freePort()), client_("127.0.0.1", port_) {
        std::vector<std::string> command = {
            program,          "serve",       "--port", std::to_string(port_), "--scene",
            subject.argument, "--log-level", "error",  "--frame-cache",       "0"};
        command.insert(command.end(), flags.begin(), flags.end());
        client_.set_read_timeout(std::chrono::seconds(300));
        client_.set_keep_alive(true);
        client_.set_tcp_nodelay(true);
        id_ = startProgram(std::move(command), folders.environment(), folders.file("log"));
    }
    ~RunningServer() { stop(); }
    RunningServer(const RunningServer&) = delete;
    RunningServer& operator=(const RunningServer&) = delete;

    void stop() {
        if (id_ > 0) stopTree(id_);
        id_ = 0;
    }
    httplib::Client& client() { return client_; }
    pid_t id() const { return id_; }
    double milliseconds() const { return watch_.milliseconds(); }
    // Whether there is time left and the process did not end by itself.
    bool goesOn() const {
        siginfo_t info{};
        waitid(P_PID, static_cast<id_t>(id_), &info, WEXITED | WNOHANG | WNOWAIT);
        return info.si_pid == 0 && milliseconds() < kLimitMs;
    }

private:
    Stopwatch watch_;
    int port_;
    httplib::Client client_;
    pid_t id_ = 0;
};

httplib::Result defaultView(httplib::Client& client) {
    return client.Post("/v1/frames", R"({"width": 1280, "height": 720, "accuracy": "standard"})",
                       "application/json");
}

std::size_t indexed(std::size_t bytes) {
    return bytes < kIndexHeader ? 0 : (bytes - kIndexHeader) / kIndexRecord;
}

}  // namespace

CacheFolders::CacheFolders()
    : folder_(fs::temp_directory_path() / ("clerestory-cold-" + std::to_string(getpid()))) {
    clear();
}

CacheFolders::~CacheFolders() {
    std::error_code error;
    fs::remove_all(folder_, error);
}

void CacheFolders::clear() const {
    fs::remove_all(folder_);
    for (const char* name : {"mesa", "xdg", "home"}) fs::create_directories(folder_ / name);
}

Environment CacheFolders::environment() const {
    return {{"MESA_SHADER_CACHE_DIR", folder_ / "mesa"},
            {"XDG_CACHE_HOME", folder_ / "xdg"},
            {"HOME", folder_ / "home"},
            {"MESA_SHADER_CACHE_DISABLE", ""},
            {"MESA_GLSL_CACHE_DISABLE", ""}};
}

CacheFolders::Content CacheFolders::shaders() const {
    Content content;
    for (const auto& item : fs::recursive_directory_iterator(folder_)) {
        const std::string path = item.path().lexically_relative(folder_);
        // Not the imported scenes, which lie below the same folder.
        const bool ofShaders = path.starts_with("mesa") || path.find("shader") != path.npos;
        if (!ofShaders || !item.is_regular_file()) continue;
        const std::string name = item.path().filename();
        ++content.files;
        content.bytes += item.file_size();
        if (name == "mesa_cache.idx") content.entries += indexed(item.file_size());
        // One file an entry, unless it belongs to a cache in few files or marks a place.
        const bool entry = name.size() >= 32 && name.find('.') == name.npos;
        content.entries += entry ? 1 : 0;
    }
    return content;
}

ServerStart measureFrames(const std::string& program, const std::vector<std::string>& flags,
                          const Subject& subject, const CacheFolders& folders) {
    ServerStart result;
    RunningServer server(program, flags, subject, folders);
    while (server.goesOn()) {
        const auto reply = defaultView(server.client());
        if (reply && reply->status == 200) {
            result.firstFrame = 1e-3 * server.milliseconds();
            break;
        }
        if (reply) ++result.before[reply->status];
        if (reply && reply->status < 500 && reply->status != 409) break;  // repeating is no use
        // Without a response the server does not listen yet. Retry-After, in whole seconds, would
        // dominate the figure.
        std::this_thread::sleep_for(reply ? kBetween : std::chrono::milliseconds(2));
    }
    result.processorSeconds = processorSeconds(processTree(server.id()));
    for (int frame = 2; result.firstFrame && frame <= kFrames; ++frame) {
        const Stopwatch watch;
        const auto reply = defaultView(server.client());
        if (!reply || reply->status != 200) ++result.after[reply ? reply->status : 0];
        if (frame == 2) result.secondFrameMs = watch.milliseconds();
        if (frame == kFrames) result.tenthFrameMs = watch.milliseconds();
    }
    if (const auto reply = server.client().Get("/v1/renderer")) result.renderer = reply->body;
    server.stop();
    result.cache = folders.shaders();
    return result;
}

std::optional<double> measureReadiness(const std::string& program,
                                       const std::vector<std::string>& flags,
                                       const Subject& subject, const CacheFolders& folders) {
    RunningServer server(program, flags, subject, folders);
    while (server.goesOn()) {
        const auto reply = server.client().Get("/readyz");
        if (reply && reply->status == 200) return 1e-3 * server.milliseconds();
        std::this_thread::sleep_for(kBetween);
    }
    return std::nullopt;
}

Run measureRender(const std::string& program, const std::vector<std::string>& flags,
                  const Subject& subject, const CacheFolders& folders) {
    std::vector<std::string> command = {program,   "render",   subject.argument,         "--size",
                                        "320x180", "--output", folders.file("frame.png")};
    command.insert(command.end(), flags.begin(), flags.end());
    const Stopwatch watch;
    const Ended end = awaitEnd(startProgram(command, folders.environment(), folders.file("log")));
    return {.ended = end.status == 0,
            .wallSeconds = 1e-3 * watch.milliseconds(),
            .processorSeconds = end.processorSeconds,
            .cache = folders.shaders()};
}

}  // namespace clerestory::bench
