//! One call of tokio-modbus at a time, polled by hand.

use std::pin::Pin;
use std::task::{Context, Poll, Waker};

use tokio_modbus::client::{self, Client as _};
use tokio_modbus::{ExceptionCode, Request, Response, Slave};

use crate::error::AnswerError;
use crate::map::{Block, Function};
use crate::pipe::Pipe;
use crate::screen::Question;
use crate::settings::Transport;

/// What a device answered.
#[derive(Debug, PartialEq, Eq)]
pub(crate) enum Answer {
    /// One value per register, or 0 or 1 per bit, as many as asked for.
    Words(Vec<u16>),
    /// An exception code.
    Refused(ExceptionCode),
}

/// Encodes requests and decodes answers with tokio-modbus over a pipe in memory.
///
/// The library's transaction ids start at 0 with every client. Ours go on as long as the driver lives
/// and are put in their place on the way out, so that an answer kept back somewhere (a gateway, a
/// connection before) fits no later request.
pub(crate) struct Caller {
    transport: Transport,
    slave: Slave,
    next_transaction: u16,
    call: Option<Call>,
    idle: Option<client::Context>,
    pipe: Pipe,
}

struct Call {
    block: Block,
    library_transaction: [u8; 2],
    future: CallFuture,
}

type CallFuture = Pin<Box<dyn Future<Output = Finished> + Send>>;
type Finished = (client::Context, tokio_modbus::Result<Response>);

impl Caller {
    pub(crate) fn new(transport: Transport, unit_id: u8) -> Caller {
        Caller {
            transport,
            slave: Slave(unit_id),
            next_transaction: 0,
            call: None,
            idle: None,
            pipe: Pipe::default(),
        }
    }

    /// Drops the call under way and the library's client with everything it has read.
    pub(crate) fn reset(&mut self) {
        self.call = None;
        self.idle = None;
        self.pipe = Pipe::default();
    }

    /// Starts a call. Gives the bytes to send and how its answer is to be known.
    pub(crate) fn ask(&mut self, block: Block) -> (Vec<u8>, Question) {
        if self.call.is_some() {
            self.reset();
        }
        let mut context = self.idle.take().unwrap_or_else(|| self.attach());
        let request = request(block);
        let mut future: CallFuture = Box::pin(async move {
            let result = context.call(request).await;
            (context, result)
        });
        // The pipe is empty, so the call cannot finish: it writes its request and waits.
        let _ = poll(&mut future);
        let mut bytes = self.pipe.drain();

        let transaction = self.next_transaction;
        let mut library_transaction = [0; 2];
        if self.transport == Transport::Tcp {
            self.next_transaction = transaction.wrapping_add(1);
            library_transaction.copy_from_slice(&bytes[..2]);
            bytes[..2].copy_from_slice(&transaction.to_be_bytes());
        }
        self.call = Some(Call { block, library_transaction, future });
        let question = Question {
            unit_id: self.slave.0,
            function: block.function.code(),
            byte_count: block.byte_count(),
            transaction,
        };
        (bytes, question)
    }

    /// Ends the call with the frame that answers it.
    ///
    /// # Errors
    ///
    /// When the library does not take the frame for the answer, or it has another length than asked.
    pub(crate) fn answer(&mut self, mut frame: Vec<u8>) -> Result<Answer, AnswerError> {
        let Some(mut call) = self.call.take() else {
            return Err(AnswerError::Incomplete);
        };
        if self.transport == Transport::Tcp {
            frame[..2].copy_from_slice(&call.library_transaction);
        }
        self.pipe.feed(&frame);
        let Poll::Ready((context, result)) = poll(&mut call.future) else {
            self.reset();
            return Err(AnswerError::Incomplete);
        };
        match result {
            Ok(Ok(response)) => {
                self.idle = Some(context);
                words(call.block, response)
            }
            Ok(Err(exception)) => {
                self.idle = Some(context);
                Ok(Answer::Refused(exception))
            }
            Err(error) => {
                self.reset();
                Err(AnswerError::Library(error))
            }
        }
    }

    fn attach(&self) -> client::Context {
        match self.transport {
            Transport::Tcp => client::tcp::attach_slave(self.pipe.clone(), self.slave),
            Transport::Rtu => client::rtu::attach_slave(self.pipe.clone(), self.slave),
        }
    }
}

fn poll(future: &mut CallFuture) -> Poll<Finished> {
    future.as_mut().poll(&mut Context::from_waker(Waker::noop()))
}

fn request(block: Block) -> Request<'static> {
    match block.function {
        Function::ReadCoils => Request::ReadCoils(block.address, block.len),
        Function::ReadDiscrete => Request::ReadDiscreteInputs(block.address, block.len),
        Function::ReadHolding => Request::ReadHoldingRegisters(block.address, block.len),
        Function::ReadInput => Request::ReadInputRegisters(block.address, block.len),
    }
}

fn words(block: Block, response: Response) -> Result<Answer, AnswerError> {
    let expected = usize::from(block.len);
    let words = match response {
        Response::ReadHoldingRegisters(words) | Response::ReadInputRegisters(words) => words,
        // The library gives whole bytes of bits.
        Response::ReadCoils(bits) | Response::ReadDiscreteInputs(bits)
            if bits.len() == expected.next_multiple_of(8) =>
        {
            bits.into_iter().take(expected).map(u16::from).collect()
        }
        Response::ReadCoils(bits) | Response::ReadDiscreteInputs(bits) => {
            return Err(AnswerError::Length { expected, found: bits.len() });
        }
        _ => return Err(AnswerError::Incomplete),
    };
    if words.len() == expected {
        Ok(Answer::Words(words))
    } else {
        Err(AnswerError::Length { expected, found: words.len() })
    }
}
