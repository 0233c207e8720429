"""Frames in, frames out: what arrives whole is kept, what is broken is a typed error, nothing hangs."""

import socket
import struct
import threading
import time

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scripted_reader import scripted_reader

pytest.importorskip("llrpkit", reason="llrpkit is not installed (extra llrp)")
from llrpkit.protocol import enums, messages, params

from rfcompass.errors import LinkLost, MalformedFrame, ReaderRefused
from rfcompass.recordings.sources.llrp_link import LONGEST_FRAME_BYTES, LlrpLink


def greeting(status=0):
    event = params.ConnectionAttemptEvent(status=status)
    data = params.ReaderEventNotificationData(
        timestamp=params.UTCTimestamp(microseconds=1), connection_attempt_event=event
    )
    return messages.READER_EVENT_NOTIFICATION(reader_event_notification_data=data).to_bytes(message_id=0)


def report(number):
    data = params.TagReportData(epc_parameter=params.EPC_96(epc=number.to_bytes(12, "big")))
    return messages.RO_ACCESS_REPORT(tag_report_datas=[data]).to_bytes(message_id=0)


def header(kind, length):
    return ((1 << 10) | kind).to_bytes(2, "big") + length.to_bytes(4, "big") + bytes(4)


def received(port):
    """Everything that arrives, and the error that ends it."""
    return rest_of(LlrpLink("127.0.0.1", port, 2.0))


def rest_of(link):
    taken = []
    try:
        while True:
            taken += link.receive(2.0)
    except LinkLost as error:
        return taken, error
    finally:
        link.close()


def says(*frames):
    return lambda connection, _: connection.sendall(greeting() + b"".join(frames))


def test_frames_arrive_whole_and_in_order():
    with scripted_reader(says(*(report(k) for k in range(500)))) as port:
        taken, error = received(port)
    assert [int.from_bytes(message.tag_report_datas[0].epc_parameter.epc, "big") for message in taken] == list(
        range(500)
    )
    assert not isinstance(error, MalformedFrame)


def test_frames_that_come_byte_by_byte_are_put_together():
    def dribble(connection, _):
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        for byte in greeting() + report(1):
            connection.sendall(bytes([byte]))

    with scripted_reader(dribble) as port:
        assert len(received(port)[0]) == 1


@settings(max_examples=150)
@given(kind=st.integers(0, 1023), body=st.binary(max_size=60))
def test_no_body_of_a_frame_raises_anything_but_a_typed_error(kind, body):
    with scripted_reader(says(report(1), header(kind, 10 + len(body)), body, report(2))) as port:
        taken, error = received(port)
    assert taken[0].tag_report_datas[0].epc_parameter.epc[-1] == 1  # what came before is never lost
    if not isinstance(error, MalformedFrame):
        assert taken[-1].tag_report_datas[0].epc_parameter.epc[-1] == 2


@settings(max_examples=150)
@given(place=st.integers(10, len(report(1)) - 1), value=st.integers(0, 255))
def test_no_damaged_report_raises_anything_but_a_typed_error(place, value):
    damaged = bytearray(report(1))
    damaged[place] = value
    with scripted_reader(says(bytes(damaged))) as port:
        assert isinstance(received(port)[1], LinkLost)


@pytest.mark.parametrize("length", [0, 9, LONGEST_FRAME_BYTES + 1, 2**32 - 1])
def test_a_length_that_cannot_be_is_malformed_and_allocates_nothing(length):
    with scripted_reader(says(report(1), header(61, length))) as port:
        taken, error = received(port)
    assert len(taken) == 1
    assert isinstance(error, MalformedFrame)
    assert error.numbers["bytes"] == length


def test_a_frame_that_is_cut_by_the_end_of_the_connection_is_a_lost_link():
    with scripted_reader(says(report(1), report(2)[:-3])) as port:
        taken, error = received(port)
    assert len(taken) == 1
    assert type(error) is LinkLost


@pytest.mark.parametrize(
    "first", [b"", b"SSH-2.0-OpenSSH\r\n", greeting(enums.ConnectionAttemptStatusType.Another_Connection_Attempted)]
)
def test_whoever_does_not_greet_as_a_reader_is_a_lost_link(first):
    with scripted_reader(lambda connection, _: connection.sendall(first)) as port, pytest.raises(LinkLost):
        LlrpLink("127.0.0.1", port, 0.5)


def test_a_port_on_which_nobody_listens_is_a_lost_link():
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
    with pytest.raises(LinkLost) as caught:
        LlrpLink("127.0.0.1", port, 0.5)
    assert caught.value.numbers["port"] == port


def test_a_silent_server_does_not_hold_us_longer_than_asked():
    with scripted_reader(lambda connection, _: connection.recv(1)) as port:
        start_s = time.monotonic()
        with pytest.raises(LinkLost, match="greeting"):
            LlrpLink("127.0.0.1", port, 0.3)
        assert time.monotonic() - start_s < 2.0


def answering(*before_the_answer, status=0, text=""):
    def script(connection, _):
        connection.sendall(greeting())
        request = connection.recv(1000)
        answer = messages.START_ROSPEC_RESPONSE(
            llrp_status=params.LLRPStatus(status_code=status, error_description=text)
        )
        # Reports come with message ids of their own, also with that of the request.
        tail = messages.RO_ACCESS_REPORT().to_bytes(message_id=int.from_bytes(request[6:10], "big"))
        frames = b"".join(before_the_answer) + tail
        connection.sendall(frames + answer.to_bytes(message_id=int.from_bytes(request[6:10], "big")) + report(9))
        connection.recv(1000)

    return script


def test_reports_around_an_answer_are_left_for_later_in_their_order():
    with scripted_reader(answering(report(7), report(8))) as port:
        link = LlrpLink("127.0.0.1", port, 2.0)
        assert isinstance(link.request(messages.START_ROSPEC(ro_spec_id=1)), messages.START_ROSPEC_RESPONSE)
        reports = [message.tag_report_datas for message in link.receive(1.0)]
        link.close()
    assert [int(datas[0].epc_parameter.epc[-1]) if datas else None for datas in reports] == [7, 8, None, 9]


def test_a_refusal_is_an_error_that_says_what_was_refused():
    with scripted_reader(answering(status=100, text="no such thing")) as port:
        link = LlrpLink("127.0.0.1", port, 2.0)
        with pytest.raises(ReaderRefused, match="no such thing") as caught:
            link.request(messages.START_ROSPEC(ro_spec_id=1))
        link.close()
    assert caught.value.numbers["status"] == 100
    assert caught.value.numbers["request"] == "START_ROSPEC"


def test_a_request_without_an_answer_is_a_lost_link():
    with scripted_reader(
        lambda connection, _: (connection.sendall(greeting()), connection.recv(1000), connection.recv(1))
    ) as port:
        link = LlrpLink("127.0.0.1", port, 0.3)
        with pytest.raises(LinkLost, match="START_ROSPEC"):
            link.request(messages.START_ROSPEC(ro_spec_id=1))
        link.close()


def test_keep_alives_are_answered_and_not_handed_out():
    answers = []

    def script(connection, _):
        connection.sendall(greeting() + messages.KEEPALIVE().to_bytes(message_id=77) + report(1))
        answers.append(connection.recv(1000))

    with scripted_reader(script) as port:
        taken, _ = received(port)
    assert len(taken) == 1
    assert answers == [messages.KEEPALIVE_ACK().to_bytes(message_id=77)]


def test_what_has_arrived_is_taken_without_waiting():
    with scripted_reader(says_in_two) as port:
        link = LlrpLink("127.0.0.1", port, 2.0)
        assert link.receive(0.0) == ()
        link.send(messages.KEEPALIVE_ACK())
        time.sleep(0.3)
        assert len(link.receive(0.0)) == 1
        link.close()


def says_in_two(connection, _):
    """Greet, and report once something was said."""
    connection.sendall(greeting())
    connection.recv(1000)
    connection.sendall(report(1))
    connection.recv(1)


def test_what_a_reader_said_before_it_hung_up_is_read_though_its_keep_alives_can_no_longer_be_answered():
    keep_alive = messages.KEEPALIVE().to_bytes(message_id=77)
    gone = threading.Event()

    def script(connection, _):
        connection.sendall(greeting())
        connection.recv(1000)
        connection.sendall(report(1) + b"".join(keep_alive + report(k) for k in range(2, 200)))
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))  # hang up with a reset
        connection.close()
        gone.set()

    with scripted_reader(script) as port:
        link = LlrpLink("127.0.0.1", port, 2.0)
        link.send(messages.KEEPALIVE_ACK())
        assert gone.wait(5.0)
        time.sleep(0.1)
        taken, _ = rest_of(link)
    assert len(taken) == 199


def test_what_may_have_been_waiting_is_told_by_the_time_since_nothing_was():
    with scripted_reader(says_in_two) as port:
        link = LlrpLink("127.0.0.1", port, 2.0)
        time.sleep(0.2)
        assert link.unread_s >= 0.2
        assert link.receive(0.0) == ()
        assert link.unread_s < 0.1
        link.close()
