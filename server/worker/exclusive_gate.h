// A lock for many threads at once or for one alone. A thread that waits to be alone is not
// overtaken by threads that come later.
#pragma once

#include <condition_variable>
#include <mutex>

namespace clerestory {

class ExclusiveGate {
public:
    class Entry {  // the lock is released when it ends
    public:
        ~Entry() { gate_.leave(alone_); }
        Entry(const Entry&) = delete;
        Entry& operator=(const Entry&) = delete;

    private:
        friend class ExclusiveGate;
        Entry(ExclusiveGate& gate, bool alone) : gate_(gate), alone_(alone) {}
        ExclusiveGate& gate_;
        bool alone_;
    };

    // Both block until they may enter.
    Entry enter();
    Entry enterAlone();

private:
    void leave(bool alone);

    std::mutex mutex_;
    std::condition_variable changed_;
    std::size_t inside_ = 0;
    std::size_t waitingAlone_ = 0;
    bool alone_ = false;
};

}  // namespace clerestory
