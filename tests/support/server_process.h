// `clerestory serve` as a child process.
#pragma once

#include <sys/types.h>
#include <string>
#include <vector>

namespace clerestory::test {

class ServerProcess {
public:
    // On a free port, quiet; returns when it says that it listens. `before` runs in the child
    // before the program begins.
    explicit ServerProcess(const std::vector<std::string>& flags = {}, void (*before)() = nullptr,
                           const std::string& program = CLERESTORY_PROGRAM);
    ~ServerProcess();  // kills it
    ServerProcess(const ServerProcess&) = delete;
    ServerProcess& operator=(const ServerProcess&) = delete;

    int port() const { return port_; }  // 0: it did not start
    pid_t id() const { return id_; }
    void signal(int number) const;
    bool waitUntilReady() const;  // false: it ended before, or five minutes passed
    int wait();                   // for its end; waitpid()'s status
    int end(int number);          // signal and wait

    std::size_t residentBytes() const;
    std::size_t descriptors() const;
    std::size_t threads() const;

private:
    bool ended() const;

    pid_t id_ = -1;
    int port_ = 0;
};

}  // namespace clerestory::test
