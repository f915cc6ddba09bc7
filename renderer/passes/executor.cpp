namespace clerestory {}
