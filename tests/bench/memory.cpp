// `bench_memory CLERESTORY [--cold] [SCENE...]`: memory of a server and its two renderers for each
// scene: the proportional set size (PSS) of every process, by kind of mapping.
//
// `room` is the scene of writeRoom(). `--cold` starts with empty caches of shaders and scenes.
#include "process_tree.h"
#include "program.h"
#include "room.h"
#include "tests/support/free_port.h"

#include <fcntl.h>
#include <httplib.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

extern char** environ;

namespace clerestory::bench {
namespace {

namespace fs = std::filesystem;

enum Kind { llvm, driver, otherFiles, heap, large, rest, shared, kKinds };
constexpr std::array<const char*, kKinds> kNames{"LLVM",  "driver", "other files", "heap",
                                                 "large", "rest",   "shared"};

struct Breakdown {
    std::array<double, kKinds> megabytes{};
    double total() const {
        double sum = 0.0;
        for (const double part : megabytes) sum += part;
        return sum;
    }
};

bool contains(const std::string& text, const char* part) {
    return text.find(part) != std::string::npos;
}

// The kind of one mapping. The allocator's further heaps start at multiples of 64 MB; blocks above
// its threshold (usually textures, targets, vertices) have their own mappings.
Kind kindOf(unsigned long long begin, unsigned long long end, const std::string& name) {
    constexpr unsigned long long kHeap = 64ull << 20, kLarge = 1ull << 20;
    if (contains(name, "libLLVM")) return llvm;
    for (const char* part : {"_dri.so", "libgallium", "libEGL", "libGL", "libgbm", "libglapi"}) {
        if (contains(name, part)) return driver;
    }
    if (contains(name, "memfd:") || contains(name, "/dev/shm")) return shared;
    if (name.starts_with("/")) return otherFiles;
    if (name == "[heap]" || (name.empty() && begin % kHeap == 0)) return heap;
    return end - begin >= kLarge ? large : rest;
}

Breakdown breakdownOf(pid_t process) {
    std::ifstream file("/proc/" + std::to_string(process) + "/smaps");
    Breakdown result;
    Kind kind = rest;
    for (std::string line; std::getline(file, line);) {
        unsigned long long begin = 0, end = 0;
        int at = 0;
        double kilobytes = 0.0;
        if (std::sscanf(line.c_str(), "%llx-%llx %*s %*s %*s %*s %n", &begin, &end, &at) == 2) {
            kind = kindOf(begin, end, at > 0 ? line.substr(static_cast<std::size_t>(at)) : "");
        } else if (std::sscanf(line.c_str(), "Pss: %lf", &kilobytes) == 1) {
            result.megabytes[kind] += kilobytes / 1024.0;
        }
    }
    return result;
}

class Server {
public:
    Server(const std::string& program, const std::string& scene) : port_(test::freePort()) {
        std::vector<std::string> words{
            program, "serve",       "--port", std::to_string(port_), "--scene",
            scene,   "--log-level", "error",  "--frame-cache",       "0"};
        std::vector<char*> arguments;
        for (std::string& word : words) arguments.push_back(word.data());
        arguments.push_back(nullptr);
        posix_spawn_file_actions_t actions;
        posix_spawn_file_actions_init(&actions);
        posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
        const int error =
            posix_spawn(&id_, arguments[0], &actions, nullptr, arguments.data(), environ);
        posix_spawn_file_actions_destroy(&actions);
        if (error != 0) throw std::runtime_error("cannot start " + program);
    }
    ~Server() {
        kill(id_, SIGTERM);
        waitpid(id_, nullptr, 0);
    }
    Server(const Server&) = delete;
    Server& operator=(const Server&) = delete;

    // `count` frames of the default view, 1280x720; repeated if the server answers Retry-After.
    void draw(int frames) {
        httplib::Client client("127.0.0.1", port_);
        client.set_read_timeout(120);
        constexpr int kMaxTries = 2400;
        for (int tries = 0; frames > 0; ++tries) {
            if (tries == kMaxTries) throw std::runtime_error("the server draws no frame");
            const auto reply =
                client.Post("/v1/frames", R"({"width":1280,"height":720})", "application/json");
            if (reply && reply->status == 200) {
                --frames;
            } else {
                std::this_thread::sleep_for(std::chrono::milliseconds(250));
            }
        }
    }

    std::vector<pid_t> processes() const {
        std::vector<pid_t> ids = workersOf(id_);
        ids.insert(ids.begin(), id_);
        return ids;
    }

    // The server first, then its renderers, once there are two, after 40 s, and when their memory
    // has stayed the same for some seconds: the second one starts a little later, and both give
    // back what they do not need when they have had nothing to do for 10 s.
    std::vector<pid_t> settled() const {
        std::vector<pid_t> ids;
        double before = 0.0;
        for (int second = 0, same = 0; second < 300 && (second < 40 || same < 8); ++second) {
            std::this_thread::sleep_for(std::chrono::seconds(1));
            ids = processes();
            double now = 0.0;
            for (const pid_t id : ids) now += breakdownOf(id).total();
            same = ids.size() == 3 && std::abs(now - before) < 0.5 ? same + 1 : 0;
            before = now;
        }
        return ids;
    }

    // The server's own count, by kind: meshes, textures, maps.
    void printScene() const {
        httplib::Client client("127.0.0.1", port_);
        const auto metrics = client.Get("/metrics");
        std::printf("  the scene in each renderer:");
        for (const char* kind : {"meshes", "textures", "maps"}) {
            const std::string key = std::string("clerestory_scene_bytes{kind=\"") + kind + "\"} ";
            const std::size_t at = metrics ? metrics->body.find(key) : std::string::npos;
            if (at == std::string::npos) continue;
            std::printf(" %s %.1f MB", kind, std::atof(&metrics->body[at + key.size()]) / 1048576);
        }
        std::printf("\n");
    }

private:
    int port_;
    pid_t id_ = 0;
};

// Megabytes (PSS) of the server and its renderers.
void print(const std::string& title, const std::vector<pid_t>& ids) {
    std::printf("%s, megabytes (PSS)\n  %-10s", title.c_str(), "");
    for (const char* kind : kNames) std::printf("%12s", kind);
    std::printf("%12s\n", "total");
    Breakdown all;
    const auto printRow = [](const char* process, const Breakdown& b) {
        std::printf("  %-10s", process);
        for (const double part : b.megabytes) std::printf("%12.1f", part);
        std::printf("%12.1f\n", b.total());
    };
    for (std::size_t i = 0; i < ids.size(); ++i) {
        const Breakdown one = breakdownOf(ids[i]);
        for (int kind = 0; kind < kKinds; ++kind) all.megabytes[kind] += one.megabytes[kind];
        printRow(i == 0 ? "server" : i == 1 ? "renderer" : "standby", one);
    }
    printRow("all", all);
}

void measure(const std::string& program, const std::string& scene, const std::string& name) {
    Server server(program, scene);
    // Where shaders were not cached, another renderer has replaced the first one by then.
    server.draw(6);
    server.settled();
    server.draw(6);
    print(name + ", after six frames of 1280x720", server.processes());
    print(name + ", at rest", server.settled());
    server.printScene();
    std::fflush(stdout);
}

int run(int argc, char** argv) {
    std::string folder = (fs::temp_directory_path() / "clerestory-memory-XXXXXX").string();
    if (!mkdtemp(folder.data())) throw std::runtime_error("cannot make a folder for the room");
    struct Remover {
        const std::string& folder;
        ~Remover() {
            std::error_code ignored;
            fs::remove_all(folder, ignored);
        }
    } const remover{folder};
    std::vector<std::string> scenes;
    bool cold = false;
    for (int i = 2; i < argc; ++i) {
        if (std::strcmp(argv[i], "--cold") == 0) {
            cold = true;
        } else {
            scenes.emplace_back(argv[i]);
        }
    }
    if (argc < 2 || scenes.empty()) {
        std::fprintf(stderr, "usage: bench_memory CLERESTORY [--cold] SCENE...\n");
        return 2;
    }
    for (std::size_t i = 0; i < scenes.size(); ++i) {
        if (cold) {
            const std::string caches = folder + "/caches" + std::to_string(i);
            setenv("XDG_CACHE_HOME", caches.c_str(), 1);
            setenv("MESA_SHADER_CACHE_DIR", caches.c_str(), 1);
        }
        const std::string& name = scenes[i];
        measure(argv[1], name == "room" ? writeRoom(folder).string() : name,
                fs::path(name).stem().string());
    }
    return 0;
}

}  // namespace
}  // namespace clerestory::bench

int main(int argc, char** argv) {
    return clerestory::bench::runProgram("bench_memory", clerestory::bench::run, argc, argv);
}
