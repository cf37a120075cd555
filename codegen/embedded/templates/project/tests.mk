
build/test: tests/test_main.c build/lib@NAME@.a
	$(CC) $(ALL_CFLAGS) -Itests $< build/lib@NAME@.a -lm -o $@
build/example: examples/main.c build/lib@NAME@.a
	$(CC) $(ALL_CFLAGS) -Itests $< build/lib@NAME@.a -lm -o $@
test: build/test
	./build/test
example: build/example
	./build/example
.PHONY: test example
