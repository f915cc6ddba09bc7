namespace clerestory::gl {}
