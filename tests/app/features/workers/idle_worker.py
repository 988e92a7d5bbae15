"""A worker that serves nothing and reports that it is ready and at work, for tests of the dispatcher."""

import sys
from multiprocessing.connection import Connection

from app.features.workers import worker_messages as messages


def main(control: int) -> None:
    dispatcher = Connection(control)
    dispatcher.send(messages.Ready(1))
    while True:
        dispatcher.send(messages.Load((), draws=True))
        if dispatcher.poll(0.02) and isinstance(dispatcher.recv(), messages.Stop):
            return


if __name__ == "__main__":
    main(int(sys.argv[2]))
