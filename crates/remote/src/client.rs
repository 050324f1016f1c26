//! One request for a range of bytes, and what its answer means.

use std::fs;
use std::io::Read;
use std::ops::Range;
use std::path::PathBuf;
use std::time::Duration;

use ureq::http::{HeaderMap, StatusCode};
use ureq::tls::{PemItem, RootCerts, TlsConfig, parse_pem};

use super::address::Address;
use super::validator::Validator;
use hedgehop_base::error::{Error, Result};

/// Environment variable that names a file with the certificates that are trusted.
const ROOTS: &str = "SSL_CERT_FILE";

/// Connections to a server at the same time.
pub(crate) const CONNECTIONS: usize = 8;

/// Longest wait for a connection, and for the first or the next bytes on one.
const CONNECT: Duration = Duration::from_secs(15);
const STALLED: Duration = Duration::from_secs(30);
/// Longest time of a request.
const REQUEST: Duration = Duration::from_secs(120);

/// Condition of a request.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Condition<'v> {
    /// Whatever is there now.
    Any,
    /// Nothing if the resource is still this one.
    Other(&'v Validator),
    /// Bytes of this resource, and of no other.
    Same(&'v Validator),
}

/// Answer of a server.
#[derive(Debug)]
pub(crate) enum Answer {
    /// The bytes of the range, and what they are of.
    Part(Vec<u8>, Validator),
    /// Nothing changed.
    Unchanged,
}

/// Failure of a request.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Trouble {
    /// Failure that may pass, and the pause that the server asks for.
    Passing(String, Option<Duration>),
    /// Another resource is there by now.
    Replaced,
    /// Failure that stays, with its remedy.
    Lasting(String),
}

/// A server, and what is asked of it.
#[derive(Debug)]
pub(crate) struct Client {
    agent: ureq::Agent,
    address: Address,
}

impl Client {
    /// Connects to nobody yet. Proxies are those of the environment.
    ///
    /// # Errors
    /// The certificates that the environment names cannot be read.
    pub fn new(address: Address) -> Result<Self> {
        let tls = TlsConfig::builder().root_certs(roots()?).build();
        let config = ureq::Agent::config_builder()
            .http_status_as_error(false)
            .user_agent(concat!("hedgehop/", env!("CARGO_PKG_VERSION")))
            .max_idle_connections(CONNECTIONS)
            .max_idle_connections_per_host(CONNECTIONS)
            .timeout_connect(Some(CONNECT))
            .timeout_recv_response(Some(STALLED))
            .timeout_per_read(Some(STALLED))
            .timeout_global(Some(REQUEST))
            .tls_config(tls);
        Ok(Self { agent: config.build().new_agent(), address })
    }

    /// Returns the address.
    pub fn address(&self) -> &Address {
        &self.address
    }

    /// Asks once for a range of bytes. Returned bytes are all of the range, up to the end of the resource.
    pub fn ask(&self, range: &Range<u64>, condition: Condition<'_>) -> Result<Answer, Trouble> {
        let mut request = self
            .agent
            .get(self.address.secret())
            .header("Range", format!("bytes={}-{}", range.start, range.end.saturating_sub(1)))
            .header("Accept-Encoding", "identity");
        let header = match condition {
            Condition::Any => None,
            Condition::Other(validator) => validator.strong_etag().map(|etag| ("If-None-Match", etag)),
            Condition::Same(validator) => validator.condition(),
        };
        if let Some((name, value)) = header {
            request = request.header(name, value);
        }

        // A name that was found once is found again.
        let is_known = matches!(condition, Condition::Same(_));
        let response = request.call().map_err(|error| match error {
            ureq::Error::HostNotFound if is_known => {
                Trouble::Passing("its host is not found any more".into(), None)
            }
            error => of_transport(error),
        })?;
        let (parts, mut body) = response.into_parts();
        match parts.status {
            StatusCode::PARTIAL_CONTENT => {}
            StatusCode::NOT_MODIFIED if matches!(condition, Condition::Other(_)) => {
                return Ok(Answer::Unchanged);
            }
            status => return Err(of_status(status, &parts.headers, condition)),
        }

        let validator = checked_head(&parts.headers, range)?;
        if let Condition::Same(expected) = condition
            && !expected.agrees(&validator)
        {
            return Err(Trouble::Replaced);
        }

        let expected = range.end.min(validator.length) - range.start;
        let mut bytes = Vec::with_capacity(expected as usize);
        // One more than there may be.
        let read = body.as_reader().take(expected + 1).read_to_end(&mut bytes);
        read.map_err(|error| of_transport(error.into()))?;
        if bytes.len() as u64 != expected {
            let what = format!("it sent {} bytes instead of {expected}", bytes.len());
            return Err(Trouble::Passing(what, None));
        }

        Ok(Answer::Part(bytes, validator))
    }
}

/// Finds the certificates that are trusted: those of the environment, as for other programs, or Mozilla's.
fn roots() -> Result<RootCerts> {
    let Some(file) = std::env::var_os(ROOTS).filter(|name| !name.is_empty()).map(PathBuf::from) else {
        return Ok(RootCerts::WebPki);
    };
    let pem = fs::read(&file)
        .map_err(|error| Error::io(&file, format!("read the certificates that {ROOTS} names"), error))?;
    let certificates = parse_pem(&pem).filter_map(|item| match item {
        Ok(PemItem::Certificate(certificate)) => Some(certificate),
        _ => None,
    });
    let certificates: Vec<_> = certificates.collect();
    if certificates.is_empty() {
        return Err(Error::invalid(file, format!("holds no certificate (PEM), and {ROOTS} names it")));
    }
    Ok(RootCerts::new_with_certs(&certificates))
}

/// Checks that an answer holds the range that was asked for, as it is; returns what it is of.
fn checked_head(headers: &HeaderMap, range: &Range<u64>) -> Result<Validator, Trouble> {
    let text = |name: &str| headers.get(name).and_then(|value| value.to_str().ok()).map(str::trim);
    if let Some(coding) = text("content-encoding").filter(|coding| !coding.eq_ignore_ascii_case("identity")) {
        return Err(Trouble::Lasting(format!(
            "the server packs what it sends (Content-Encoding: {coding}); have it send .hop files as they are"
        )));
    }

    let Some((start, end, length)) = text("content-range").and_then(content_range) else {
        let what = "the server does not say which bytes of how many it sends (Content-Range); put the file on another one";
        return Err(Trouble::Lasting(what.into()));
    };
    if (start, end) != (range.start, range.end.min(length)) {
        let what = format!("it sent bytes {start} to {end} for {} to {}", range.start, range.end);
        return Err(Trouble::Passing(what, None));
    }

    let (etag, last_modified) = (text("etag").map(str::to_owned), text("last-modified").map(str::to_owned));
    Ok(Validator { etag, last_modified, length })
}

/// Reads `bytes 0-99/1234`: the first byte, the one behind the last, and bytes in all.
fn content_range(text: &str) -> Option<(u64, u64, u64)> {
    let (range, length) = text.strip_prefix("bytes ")?.split_once('/')?;
    let (first, last) = range.split_once('-')?;
    let (first, last, length) = (first.parse().ok()?, last.parse::<u64>().ok()?, length.parse().ok()?);
    let end = last.checked_add(1)?;
    (first < end && end <= length).then_some((first, end, length))
}

/// Tells what an answer without bytes means.
fn of_status(status: StatusCode, headers: &HeaderMap, condition: Condition<'_>) -> Trouble {
    let is_bound = matches!(condition, Condition::Same(_));
    let asked = || {
        let seconds = headers.get("retry-after").and_then(|value| value.to_str().ok()?.trim().parse().ok());
        seconds.map(Duration::from_secs)
    };

    match status.as_u16() {
        412 => Trouble::Replaced,
        416 if is_bound => Trouble::Replaced,
        408 | 425 | 429 | 500..=599 => Trouble::Passing(format!("the server answered {status}"), asked()),
        200 => Trouble::Lasting(
            "the server does not give parts of files (it answered a range with 200 OK); download the file and name the copy, \
             or put it on a server that knows ranges"
                .into(),
        ),
        401 | 403 => Trouble::Lasting(format!(
            "the server refuses it ({status}); if the URL was signed, it may have expired: sign a new one"
        )),
        404 => Trouble::Lasting(format!("nothing is there ({status}); check the address")),
        410 => Trouble::Lasting(format!("it is there no more ({status}); ask for its new address")),
        _ => Trouble::Lasting(format!("the server answered {status}; check the address")),
    }
}

/// Tells what a request without an answer means. Nothing that may hold the URL is repeated.
fn of_transport(error: ureq::Error) -> Trouble {
    use ureq::Error as E;
    let lasting = |what: &str| Trouble::Lasting(what.to_owned());
    match error {
        E::BadUri(_) | E::Http(_) => lasting("this is no URL that can be asked for; check its signs"),
        E::HostNotFound => lasting("there is no such host; check the address, and the network"),
        E::TooManyRedirects | E::RedirectFailed => {
            lasting("it redirects for ever; give the address where it is")
        }
        E::InvalidProxyUrl => {
            lasting("the proxy of the environment is no URL; check http_proxy and https_proxy")
        }
        E::ConnectProxyFailed(_) => lasting("the proxy refuses to connect; check http_proxy and https_proxy"),
        E::Tls(what) => {
            Trouble::Lasting(format!("no secure connection ({what}); check the server's certificate"))
        }
        E::Rustls(what) => {
            Trouble::Lasting(format!("no secure connection ({what}); check the server's certificate"))
        }
        E::Timeout(what) => Trouble::Passing(format!("it takes too long ({what})"), None),
        E::Io(error) => of_io(&error),
        E::ConnectionFailed => Trouble::Passing("no connection".into(), None),
        E::Protocol(_) => Trouble::Passing("its answer is cut short or is no HTTP".into(), None),
        _ => Trouble::Passing("the connection failed".into(), None),
    }
}

/// Tells what a failed connection means: a certificate that is not trusted stays so.
fn of_io(error: &std::io::Error) -> Trouble {
    if error.kind() == std::io::ErrorKind::InvalidData {
        return Trouble::Lasting(format!("no secure connection ({error}); check the server's certificate"));
    }
    Trouble::Passing(error.to_string(), None)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn headers(lines: &[(&'static str, &str)]) -> HeaderMap {
        lines.iter().map(|(name, value)| (name.parse().unwrap(), value.parse().unwrap())).collect()
    }

    #[test]
    fn ranges_are_those_asked_for() {
        assert_eq!(content_range("bytes 0-99/1234"), Some((0, 100, 1234)));
        for wrong in ["bytes 0-99/*", "bytes 9-0/100", "bytes 0-100/100", "items 0-1/2", "bytes 0-1", ""] {
            assert_eq!(content_range(wrong), None, "{wrong}");
        }

        let range = 100..300;
        let head = |range_sent: &str| {
            checked_head(&headers(&[("content-range", range_sent), ("etag", "\"a\"")]), &range)
        };
        assert_eq!(head("bytes 100-299/500").unwrap().length, 500);
        assert_eq!(head("bytes 100-199/200").unwrap().strong_etag(), Some("\"a\""));
        assert!(matches!(head("bytes 100-199/500"), Err(Trouble::Passing(..))));
        assert!(matches!(head("bytes 0-199/500"), Err(Trouble::Passing(..))));
    }

    #[test]
    fn packed_answers_are_refused() {
        let packed = headers(&[("content-range", "bytes 0-9/10"), ("content-encoding", "gzip")]);
        assert!(
            matches!(checked_head(&packed, &(0..10)), Err(Trouble::Lasting(what)) if what.contains("gzip"))
        );
    }

    #[test]
    fn answers_that_may_change_are_told_from_those_that_stay() {
        let validator = Validator { length: 10, ..Validator::default() };
        let answer = |code: u16, condition| {
            of_status(StatusCode::from_u16(code).unwrap(), &headers(&[("retry-after", "7")]), condition)
        };
        let asked = Some(Duration::from_secs(7));
        for code in [429, 500, 503] {
            assert!(
                matches!(answer(code, Condition::Any), Trouble::Passing(_, wait) if wait == asked),
                "{code}"
            );
        }
        for code in [200, 301, 401, 403, 404, 410, 416] {
            assert!(matches!(answer(code, Condition::Any), Trouble::Lasting(_)), "{code}");
        }
        assert_eq!(answer(412, Condition::Same(&validator)), Trouble::Replaced);
        assert_eq!(answer(416, Condition::Same(&validator)), Trouble::Replaced);
    }
}
