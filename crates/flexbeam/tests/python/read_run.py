"""What the public packages make of a run: one line for each thing, numbers as the bytes they are made of.

read_run.py run.mcap          by the file's index
read_run.py run.mcap --stream from its beginning, as far as it goes
"""

import hashlib
import struct
import sys

from mcap.exceptions import McapError
from mcap.reader import NonSeekingReader, SeekingReader
from mcap_ros2.decoder import DecoderFactory

REALS = "voltage_v commanded_v u_v reference_rad smoothed_rad theta_rad alpha_rad psi_rad y_model_rad error_rad".split()
COUNTS = "lateness_ns execution_ns settings phase fault stale".split()


def show(topic, message, data):
    if topic != "/signals":
        print("json", topic, message.log_time, message.data.decode())
        return
    reals = (struct.pack("<d", getattr(data, name)).hex() for name in REALS)
    counts = (str(getattr(data, name)) for name in COUNTS)
    print("sample", message.log_time, data.tick, *reals, *counts)


def messages(reader, **order):
    for schema, channel, message in reader.iter_messages(**order):
        decode = DecoderFactory().decoder_for(channel.message_encoding, schema)
        show(channel.topic, message, decode(message.data) if decode else None)


path, stream = sys.argv[1], "--stream" in sys.argv
with open(path, "rb") as file:
    if stream:
        try:
            messages(NonSeekingReader(file, validate_crcs=True), log_time_order=False)
            print("end")
        except (McapError, struct.error, EOFError) as error:
            print("cut", type(error).__name__)
    else:
        reader = SeekingReader(file, validate_crcs=True)
        messages(reader)
        for attachment in reader.iter_attachments():
            print("attachment", attachment.name, attachment.media_type, hashlib.sha256(attachment.data).hexdigest())
        for record in reader.iter_metadata():
            for key, text in sorted(record.metadata.items()):
                print("metadata", record.name, key, text)
        print("end")
