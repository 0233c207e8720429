"""A reader that says what a test tells it to: raw bytes on a socket, no protocol of its own."""

import socket
import threading
from collections.abc import Callable
from contextlib import contextmanager, suppress


@contextmanager
def scripted_reader(script: Callable[[socket.socket, int], None]):
    """Listen on a free port; run `script(connection, number)` for each connection, then close it. Yields the port."""
    server = socket.create_server(("127.0.0.1", 0))

    def serve() -> None:
        number = 0
        while True:
            try:
                connection, _ = server.accept()
            except OSError:
                return
            with connection, suppress(OSError):
                script(connection, number)
            number += 1

    thread = threading.Thread(target=serve, daemon=True)
    thread.start()
    try:
        yield server.getsockname()[1]
    finally:
        server.shutdown(socket.SHUT_RDWR)
        server.close()
        thread.join(5.0)
