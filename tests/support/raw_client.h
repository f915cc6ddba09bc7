// A client of raw bytes: sends what no library would, at any speed.
#pragma once

#include <string>
#include <string_view>

namespace clerestory::test {

class RawClient {
public:
    // Connects to 127.0.0.1, from that address of the same network.
    explicit RawClient(int port, const char* from = nullptr, int receiveBuffer = 0);
    ~RawClient();
    RawClient(RawClient&& other) noexcept;
    RawClient& operator=(RawClient&&) = delete;

    bool connected() const { return socket_ >= 0; }
    bool send(std::string_view bytes);  // all, waiting up to 10 s; false: refused by the other side
    std::string receive(
        double seconds);  // all that comes until the other side ends, or in that time
    std::string answer(double seconds);  // one with a Content-Length; what there is when time is up
    bool endsWithin(double seconds);     // reads on; whether the other side has closed
    void halfClose();
    void reset();  // closes with RST
    int socket() const { return socket_; }

private:
    int socket_ = -1;
};

int statusOf(std::string_view answer);  // 0: none
std::string headerOf(std::string_view answer, std::string_view name);
std::string_view bodyOf(std::string_view answer);

// One request on a connection of its own.
std::string ask(int port, std::string_view request, double seconds = 10.0,
                const char* from = nullptr);
std::string get(const std::string& path, const std::string& more = "");  // the request's bytes
std::string post(const std::string& path, const std::string& body, const std::string& more = "");
// A line of /metrics, with its labels; -1: there is none.
double metric(int port, const std::string& name);

}  // namespace clerestory::test
