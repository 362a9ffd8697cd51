//! Requests and answers by turns, so that no answer leaves without the security headers.
//!
//! hyper refuses a head that is no HTTP by itself, before any route sees it, and its answer has no headers of ours. Therefore it
//! gets one head at a time, and nothing more before the answer has left. So all that it writes while no request is being answered
//! is its own refusal. [`Turns`] puts a refusal with all headers in its place.

use std::io;
use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicU8, Ordering};
use std::task::{Context, Poll, Waker, ready};

use axum::body::{Body, Bytes};
use axum::http::{HeaderMap, HeaderValue, Method, Request, Response, StatusCode, header};
use hyper::body::{Frame, SizeHint};
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};

use super::guard;
use super::problem::Problem;

/// A socket that lets hyper see one head at a time.
pub(super) struct Turns<S> {
    socket: S,
    turn: Turn,
    /// Read, and not handed on yet.
    ahead: Vec<u8>,
    /// The client has sent all it will.
    ended: bool,
    head: Head,
    /// Who waits for the next turn.
    reader: Option<Waker>,
    /// What hyper wrote out of turn.
    refusal: Vec<u8>,
    /// The refusal as it leaves, and how much of it has left.
    leaving: Option<(Vec<u8>, usize)>,
}

/// Whose turn it is on one connection.
#[derive(Clone)]
pub(super) struct Turn(Arc<AtomicU8>);

/// The client's: a head is read.
const HEAD: u8 = 0;
/// A request without a body is answered.
const ANSWER: u8 = 1;
/// The answer is with hyper, and leaves.
const LEAVES: u8 = 2;
/// No further head follows on this connection.
const LAST: u8 = 3;

impl Turn {
    pub(super) fn new() -> Turn {
        Turn(Arc::new(AtomicU8::new(HEAD)))
    }

    /// hyper has read a head. Gives whether the connection ends with the answer: bytes behind this head may belong to its body or
    /// to another protocol.
    pub(super) fn begin(&self, request: &Request<Body>) -> bool {
        let is_last = !hyper::body::Body::is_end_stream(request.body())
            || request.headers().contains_key(header::UPGRADE)
            || request.method() == Method::CONNECT;
        self.0.store(if is_last { LAST } else { ANSWER }, Ordering::Release);
        is_last
    }

    /// The answer as it is handed to hyper.
    pub(super) fn answer(&self, answer: Response<Body>, is_last: bool) -> Response<Answer> {
        let mut answer = answer.map(|body| Answer { body, turn: self.clone() });
        if is_last && answer.status() != StatusCode::SWITCHING_PROTOCOLS {
            answer.headers_mut().insert(header::CONNECTION, HeaderValue::from_static("close"));
        }
        answer
    }

    fn is(&self, turn: u8) -> bool {
        self.0.load(Ordering::Acquire) == turn
    }

    fn pass(&self, from: u8, to: u8) -> bool {
        self.0.compare_exchange(from, to, Ordering::AcqRel, Ordering::Acquire).is_ok()
    }
}

/// A body that tells when hyper has all of it.
pub(super) struct Answer {
    body: Body,
    turn: Turn,
}

impl hyper::body::Body for Answer {
    type Data = Bytes;
    type Error = axum::Error;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, axum::Error>>> {
        Pin::new(&mut self.body).poll_frame(context)
    }

    fn is_end_stream(&self) -> bool {
        self.body.is_end_stream()
    }

    fn size_hint(&self) -> SizeHint {
        self.body.size_hint()
    }
}

impl Drop for Answer {
    fn drop(&mut self) {
        self.turn.pass(ANSWER, LEAVES);
    }
}

/// How far a head was handed on.
#[derive(Clone, Copy, PartialEq)]
enum Head {
    /// Nothing but empty lines, which hyper passes over.
    Before,
    /// Within a line.
    Line,
    /// A line has ended.
    Ended,
    /// A line has ended, and a carriage return came.
    Return,
    /// An empty line has ended the head.
    Whole,
}

impl Head {
    /// Lines end as hyper's parser lets them end: by a line feed, with or without a carriage return.
    fn after(self, byte: u8) -> Head {
        match (self, byte) {
            (Head::Whole, _) | (Head::Ended | Head::Return, b'\n') => Head::Whole,
            (Head::Before, b'\r' | b'\n') => Head::Before,
            (Head::Ended, b'\r') => Head::Return,
            (Head::Line, b'\n') => Head::Ended,
            _ => Head::Line,
        }
    }
}

impl<S> Turns<S> {
    pub(super) fn new(socket: S, turn: Turn) -> Turns<S> {
        Turns {
            socket,
            turn,
            ahead: Vec::new(),
            ended: false,
            head: Head::Before,
            reader: None,
            refusal: Vec::new(),
            leaving: None,
        }
    }

    /// Whether hyper may have bytes now.
    fn is_open(&self) -> bool {
        self.turn.is(LAST) || (self.turn.is(HEAD) && self.head != Head::Whole)
    }

    /// Hands on what has been read, up to the end of the head.
    fn hand_on(&mut self, buffer: &mut ReadBuf<'_>) {
        let mut count = self.ahead.len().min(buffer.remaining());
        if self.turn.is(HEAD) {
            let mut head = self.head;
            let ends = self.ahead[..count].iter().position(|&byte| {
                head = head.after(byte);
                head == Head::Whole
            });
            self.head = head;
            count = ends.map_or(count, |end| end + 1);
        }
        buffer.put_slice(&self.ahead[..count]);
        self.ahead.drain(..count);
    }
}

impl<S: AsyncRead + Unpin> Turns<S> {
    /// Reads some bytes, or that the client has sent all it will.
    fn poll_fill(&mut self, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        let mut chunk = [0; CHUNK];
        let mut buffer = ReadBuf::new(&mut chunk);
        ready!(Pin::new(&mut self.socket).poll_read(context, &mut buffer))?;
        self.ended = buffer.filled().is_empty();
        self.ahead.extend_from_slice(buffer.filled());
        Poll::Ready(Ok(()))
    }
}

impl<S: AsyncRead + Unpin> AsyncRead for Turns<S> {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        let this = &mut *self;
        if this.ahead.is_empty() && !this.ended {
            this.reader = Some(context.waker().clone());
            // Out of turn, too: a client that is gone needs no answer.
            ready!(this.poll_fill(context))?;
        }
        if this.ahead.is_empty() {
            return Poll::Ready(Ok(()));
        }
        if !this.is_open() {
            this.reader = Some(context.waker().clone());
            return Poll::Pending;
        }
        this.hand_on(buffer);
        Poll::Ready(Ok(()))
    }
}

impl<S: AsyncWrite + Unpin> Turns<S> {
    /// Sends what stands in the place of hyper's own refusal.
    fn poll_refuse(&mut self, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        if self.refusal.is_empty() {
            return Poll::Ready(Ok(()));
        }
        let (answer, sent) = self.leaving.get_or_insert_with(|| (refusal(&self.refusal), 0));
        while *sent < answer.len() {
            let taken = ready!(Pin::new(&mut self.socket).poll_write(context, &answer[*sent..]))?;
            if taken == 0 {
                return Poll::Ready(Err(io::ErrorKind::WriteZero.into()));
            }
            *sent += taken;
        }
        Poll::Ready(Ok(()))
    }
}

impl<S: AsyncWrite + Unpin> AsyncWrite for Turns<S> {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        if self.turn.is(HEAD) {
            self.refusal.extend_from_slice(bytes);
            return Poll::Ready(Ok(bytes.len()));
        }
        Pin::new(&mut self.socket).poll_write(context, bytes)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        slices: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        if self.turn.is(HEAD) {
            slices.iter().for_each(|bytes| self.refusal.extend_from_slice(bytes));
            return Poll::Ready(Ok(slices.iter().map(|bytes| bytes.len()).sum()));
        }
        Pin::new(&mut self.socket).poll_write_vectored(context, slices)
    }

    fn is_write_vectored(&self) -> bool {
        self.socket.is_write_vectored()
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        ready!(self.poll_refuse(context))?;
        ready!(Pin::new(&mut self.socket).poll_flush(context))?;
        // hyper flushes once all it has is written.
        if self.turn.pass(LEAVES, HEAD) {
            self.head = Head::Before;
            if let Some(reader) = self.reader.take() {
                reader.wake();
            }
        }
        Poll::Ready(Ok(()))
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        ready!(self.poll_refuse(context))?;
        Pin::new(&mut self.socket).poll_shutdown(context)
    }
}

/// hyper's own refusal with our headers and a body; nothing for what is none, so that the connection just closes.
fn refusal(theirs: &[u8]) -> Vec<u8> {
    let head = std::str::from_utf8(theirs).ok().and_then(|text| text.strip_suffix("\r\n\r\n"));
    let Some((status_line, lines)) = head.and_then(|head| head.split_once("\r\n")) else {
        return Vec::new();
    };
    let code = status_line.split(' ').nth(1).and_then(|code| code.parse::<StatusCode>().ok());
    let body = problem(code.unwrap_or(StatusCode::BAD_REQUEST)).json();
    let mut headers = HeaderMap::new();
    headers.insert(header::CONTENT_TYPE, HeaderValue::from_static("application/json"));
    headers.insert(header::CONTENT_LENGTH, body.len().into());
    headers.insert(header::CONNECTION, HeaderValue::from_static("close"));
    guard::add_headers(&mut headers, true);
    let mut answer = format!("{status_line}\r\n").into_bytes();
    let kept = lines.split("\r\n").filter(|line| {
        let name = line.split(':').next().unwrap_or_default();
        !headers.contains_key(name.to_ascii_lowercase())
    });
    kept.for_each(|line| answer.extend_from_slice(format!("{line}\r\n").as_bytes()));
    for (name, value) in &headers {
        answer.extend_from_slice(format!("{name}: ").as_bytes());
        answer.extend_from_slice(value.as_bytes());
        answer.extend_from_slice(b"\r\n");
    }
    answer.extend_from_slice(b"\r\n");
    answer.extend_from_slice(&body);
    answer
}

fn problem(status: StatusCode) -> Problem {
    match status {
        StatusCode::URI_TOO_LONG => Problem::new(status, "the address is too long")
            .expected("an address below 64 kB")
            .hint("shorten the query"),
        StatusCode::REQUEST_HEADER_FIELDS_TOO_LARGE => {
            Problem::new(status, "the head of the request is too long")
                .expected("at most 100 headers and 64 kB")
                .hint("delete the cookies of this address")
        }
        _ => Problem::new(status, "the request cannot be read")
            .expected("a request of HTTP/1.1")
            .hint("use http:// and not https:// in the address; a proxy adds encryption"),
    }
}

/// Read at one time.
const CHUNK: usize = 8 * 1024;

#[cfg(test)]
mod tests {
    use super::*;

    fn whole_after(bytes: &[u8]) -> Option<usize> {
        let mut head = Head::Before;
        bytes.iter().position(|&byte| {
            head = head.after(byte);
            head == Head::Whole
        })
    }

    #[test]
    fn a_head_ends_where_its_parser_ends_it() {
        for head in [
            "GET / HTTP/1.1\r\n\r\n",
            "GET / HTTP/1.1\n\n",
            "\r\n\n\r\nGET / HTTP/1.1\r\n\n",
            "GET / HTTP/1.1\r\nHost: x\n\r\n",
        ] {
            let text = format!("{head}GET /second HTTP/1.1\r\n\r\n");
            assert_eq!(whole_after(text.as_bytes()), Some(head.len() - 1), "{head:?}");
            assert_eq!(whole_after(&head.as_bytes()[..head.len() - 1]), None, "{head:?}");
        }
        assert_eq!(whole_after(b"\r\n\r\n\n\n"), None, "empty lines before a head are none");
        assert_eq!(whole_after(b"GET /\r\n\rx\n"), None);
    }

    #[test]
    fn a_refusal_keeps_its_status_and_its_date() {
        let theirs = b"HTTP/1.1 431 Request Header Fields Too Large\r\ncontent-length: 0\r\n\
                       connection: close\r\ndate: Tue, 24 Nov 2026 11:30:00 GMT\r\n\r\n";
        let ours = String::from_utf8(refusal(theirs)).unwrap();
        let (head, body) = ours.split_once("\r\n\r\n").unwrap();
        assert!(head.starts_with("HTTP/1.1 431 Request Header Fields Too Large\r\n"), "{head}");
        assert!(head.contains("\r\ndate: Tue, 24 Nov 2026 11:30:00 GMT"), "{head}");
        assert!(head.contains(&format!("\r\ncontent-length: {}", body.len())), "{head}");
        assert_eq!(head.matches("content-length").count(), 1, "{head}");
        assert_eq!(head.matches("connection: close").count(), 1, "{head}");
        assert!(head.contains("\r\ncontent-security-policy: default-src"), "{head}");
        for no_refusal in ["", "HTTP/1.1 400 Bad Request", "HTTP/1.1 400 Bad\r\nx: y\r\n\r\nrest"] {
            assert!(refusal(no_refusal.as_bytes()).is_empty(), "{no_refusal:?}");
        }
    }
}
