        {@SLOPE@},
