// Many files in one answer, sent as they come: a tar, or parts of a multipart message.
#pragma once

#include "server/base/call.h"

#include <memory>
#include <string>
#include <string_view>

namespace clerestory {

class Archive {
public:
    virtual ~Archive() = default;
    // Both return false if the client has disconnected, or the file could not be written
    // completely.
    virtual bool add(const std::string& name, const std::string& type, std::string_view bytes) = 0;
    virtual bool end() = 0;
};

// `sink` is only called during add() and end(), and must live until then. The same files give the
// same bytes: entries have no date and no owner.
std::unique_ptr<Archive> tarArchive(const Sink& sink);
std::unique_ptr<Archive> multipartArchive(const Sink& sink);

}  // namespace clerestory
