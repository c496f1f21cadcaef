//! Connections: one request each, read within limits of time and length, answered and closed.

use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use relume::{Job, Result};

use super::site::{ViewerSite, refused};

/// The longest head of a request.
const MOST_BYTES: usize = 16 << 10;
/// The time in which a request has to arrive, and an answer to be taken, between two of its parts.
const PATIENCE: Duration = Duration::from_secs(10);
/// Connections at a time.
const MOST_CONNECTIONS: usize = 64;
/// The pause after a connection that the system could not accept.
const PAUSE: Duration = Duration::from_millis(50);

/// Answers requests until the job is cancelled. The signal that cancels it also ends the program.
pub fn serve(listener: &TcpListener, site: &ViewerSite, job: &Job) -> Result<()> {
    let open = AtomicUsize::new(0);
    std::thread::scope(|scope| {
        loop {
            let accepted = listener.accept();
            job.proceed()?;
            let Ok((mut stream, _)) = accepted else {
                std::thread::sleep(PAUSE);
                continue;
            };
            if open.fetch_add(1, Ordering::SeqCst) >= MOST_CONNECTIONS {
                open.fetch_sub(1, Ordering::SeqCst);
                let _ = stream.write_all(refused("503 Service Unavailable").head.as_bytes());
                continue;
            }
            let open = &open;
            let started = std::thread::Builder::new().spawn_scoped(scope, move || {
                // A browser that has gone away needs no answer.
                let _ = converse(&mut stream, site);
                open.fetch_sub(1, Ordering::SeqCst);
            });
            if started.is_err() {
                open.fetch_sub(1, Ordering::SeqCst);
            }
        }
    })
}

fn converse(stream: &mut TcpStream, site: &ViewerSite) -> std::io::Result<()> {
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    let answer = match head_of(stream)? {
        Some((head, begun)) => {
            let length = site.body_length(&head).unwrap_or(0);
            let body = body_of(stream, begun, length)?;
            site.answer(&head, &body)
        }
        None => refused("431 Request Header Fields Too Large"),
    };
    stream.write_all(answer.head.as_bytes())?;
    stream.write_all(&answer.body)?;
    stream.flush()
}

/// The head of a request with its empty line, and what came after it; `None` for a head that is too long.
fn head_of(stream: &mut TcpStream) -> std::io::Result<Option<(Vec<u8>, Vec<u8>)>> {
    let (mut head, mut part, begun) = (Vec::new(), [0u8; 2048], Instant::now());
    loop {
        if let Some(end) = head.windows(4).position(|end| end == b"\r\n\r\n") {
            let rest = head.split_off(end + 4);
            return Ok(Some((head, rest)));
        }
        if head.len() >= MOST_BYTES {
            return Ok(None);
        }
        let count = stream.read(&mut part)?;
        if count == 0 || begun.elapsed() > PATIENCE {
            return Err(std::io::ErrorKind::UnexpectedEof.into());
        }
        head.extend_from_slice(&part[..count]);
    }
}

/// The content of a request, of which the beginning has come with its head.
fn body_of(stream: &mut TcpStream, mut body: Vec<u8>, length: usize) -> std::io::Result<Vec<u8>> {
    let (mut part, begun) = ([0u8; 16384], Instant::now());
    while body.len() < length {
        let count = stream.read(&mut part)?;
        if count == 0 || begun.elapsed() > PATIENCE {
            return Err(std::io::ErrorKind::UnexpectedEof.into());
        }
        body.extend_from_slice(&part[..count]);
    }
    body.truncate(length);
    Ok(body)
}
