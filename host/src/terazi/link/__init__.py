# SPDX-License-Identifier: MIT
"""The wire from the host's side: ports, bytes, frames, messages, requests.

    with open_link("/dev/ttyACM0") as link:
        print(link.hello())
        for received in link.messages():
            ...

The bytes are decoded by the firmware's own C codec (`terazi.cshared`).
"""

from terazi.link.link import Link, open_link
from terazi.link.ports import Port, find_port, list_ports
from terazi.link.stream import MessageStream, Received
from terazi.link.transport import BAUD_DEFAULT, BAUDS, SerialTransport, Transport

__all__ = [
    "BAUDS",
    "BAUD_DEFAULT",
    "Link",
    "MessageStream",
    "Port",
    "Received",
    "SerialTransport",
    "Transport",
    "find_port",
    "list_ports",
    "open_link",
]
