    case @MACRO@_GAP: return "ok, with a gap below: there are more intervals";
