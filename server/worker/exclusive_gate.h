// Many at once, or one alone; whoever wants to be alone does not wait behind those who come later.
#pragma once

#include <condition_variable>
#include <mutex>

namespace clerestory {

class ExclusiveGate {
public:
    class Entry {  // leaves when it ends
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

    // Both wait until there is room.
    Entry enter();
    Entry enterAlone();

private:
    void leave(bool alone);

    std::mutex mutex_;
    std::condition_variable changed_;
    std::size_t inside_ = 0;
    std::size_t wantAlone_ = 0;
    bool alone_ = false;
};

}  // namespace clerestory
