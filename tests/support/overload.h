// Overload: clients that do not wait for one another, one that floods, shutdown under load.
#pragma once

#include "tests/support/server_process.h"

#include <string>
#include <vector>

namespace clerestory::test {

struct SentRequest {
    int status = 0;             // 0: no whole answer
    double milliseconds = 0.0;  // from when it should have been sent
    bool saysWhen = false;      // Retry-After
};

// Sends `perSecond` requests per second for `seconds`, each on its own connection, whatever the
// responses back; waits for answers up to `patience` seconds after the last.
std::vector<SentRequest> openLoop(int port, const std::string& request, double perSecond,
                                  double seconds, double patience, const char* from = nullptr);

// Value below which that share of the milliseconds of shots of a status lies; 0 without any.
double percentile(const std::vector<SentRequest>& shots, int status, double share);
int countOf(const std::vector<SentRequest>& shots, int status);

struct Overload {
    double serviceMs = 0.0;  // of one frame alone
    std::vector<SentRequest> frames, health;
    double seconds = 0.0;  // until the last answer
    // Fractions of the time of all processors: by these clients, on the same machine, and by the
    // server process.
    double clientShare = 0.0, frontShare = 0.0;

    // Frames done, of those that could be done one after the other in the time that it took.
    double goodput() const;
    // The same of what the clients left of the machine. A renderer in software uses every
    // processor there is, and so what the clients take is taken from it.
    double goodputOfTheRest() const { return goodput() / (1.0 - clientShare); }
};
// L1, L2. `queue`: what the server was started with.
Overload overload(const ServerProcess& server, double factor, double seconds);

struct Flood {
    std::vector<SentRequest> alone, duringFlood;  // of three well-behaved clients
    std::vector<SentRequest> flooder;
};
// L3.
Flood flood(const ServerProcess& server, double seconds);

// A2 of the catalogue of attacks: 24 connections of tiny frames from one address, and one expensive
// frame a second from another one, which are returned.
struct CheapFlood {
    std::vector<SentRequest> moderate, flooder;
};
CheapFlood cheapFlood(const ServerProcess& server, double seconds);

struct ShutdownCounts {
    int times = 0, cleanExits = 0;
    int answered = 0, refused = 0, notReached = 0;
    int broken = 0;  // an answer that began and did not end, or none to a request before the signal
    double slowestExit = 0;  // seconds from the signal
};
// U1: SIGTERM while eight clients request frames.
ShutdownCounts endUnderLoad(int times, const std::vector<std::string>& flags = {});

// A frame that takes a while, as a request's bytes on a connection of its own.
std::string slowFrame();

}  // namespace clerestory::test
