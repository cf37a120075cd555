
build/override: examples/override.c build/lib@NAME@.a
	$(CC) $(ALL_CFLAGS) $< build/lib@NAME@.a -lm -o $@
override: build/override
	./build/override
.PHONY: override
